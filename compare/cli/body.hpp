#pragma once

#include <Eigen/Core>
#include <array>
#include <dragcore/drag.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cli {

/// A body from a file, ready for forces. Everything that `dragval mesh` and `dragval drag` know of a file comes from here.
struct Body {
  dragcore::TriangleMesh mesh;  ///< as the forces see it [m]
  dragcore::Surface surface;
  dragcore::MeshProperties properties;  ///< of `mesh` with what no wind reaches
  int triangles_of_file = 0;
  std::vector<std::string> notes;       ///< what the reader of the file has to say, a sentence each
  std::vector<std::string> findings;    ///< what was found and changed between file and surface, a sentence each
  /// Windward area summed over the triangles, before exposure, over that of the silhouette: the largest of six directions; 1 of a convex body.
  double windward_ratio = 1.0;
  std::array<double, 3> silhouette{};  ///< area seen along x, y and z [m^2]

  Eigen::Vector3d extents() const;  ///< edges of the box along the axes that holds the mesh [m]
};

/// The file and how to read it, as the commands ask for it.
struct BodyOptions {
  std::string file;
  std::string unit;  ///< of the file: mm, cm, m, in, ft, or its size [m]; empty: metres, and a question where that is unlikely
  bool sheet = false;

  double unit_m() const;  ///< @throws UsageError  for anything else
};
void add_body_options(CLI::App& command, BodyOptions& options);

/// @throws UsageError, std::runtime_error  unit, file or mesh not as needed: the message names the file, and for a mesh its extents
Body load_body(const BodyOptions& options);

/// Four digits. @param scale  of the quantity: what is below 1e-12 of it is rounding, and shown as 0
std::string text(double value, double scale = 1.0);

/// "Is the file in millimetres?", where nobody gave the unit and a body of that many metres is unlikely; else empty.
std::string unit_question(const BodyOptions& options, const Body& body);

/// What makes the model doubtful for this body in this motion, in words, a sentence each; empty where nothing is known to.
std::vector<std::string> validity(const Body& body, const dragcore::Motion& motion, const dragcore::Medium& medium,
                                  const dragcore::Model& model);

}  // namespace cli
