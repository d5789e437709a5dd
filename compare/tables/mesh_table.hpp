#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "compare/reference/uncertainty.hpp"
#include "compare/tables/error_table.hpp"

namespace compare {

/// What the mesh leaves open of the drag of a kind of body in one flow, over all its poses. Shares are u_disc of C_D over C_D.
struct MeshRow {
  std::string body, flow;  ///< kind of shape; "Re 1e5, k_omega_sst"
  double aim = 0.0;        ///< 0.03 of a turbulent flow, 0.015 of a laminar one
  int poses = 0, within_aim = 0;
  int three_levels = 0, two_levels = 0, carried = 0, unknown = 0;  ///< how u_disc was found: they add up to `poses`
  double median = 0.0, largest = 0.0;                              ///< of the poses whose u_disc is known
  std::string worst;                                               ///< the pose of `largest`, with the rule that made it
  /// Largest of the force components that symmetry says are zero, over what mesh, iteration and time leave open of that component and, for
  /// the mesh, of the drag: below 1, asymmetry is inside the uncertainty.
  double null = 0.0;
};

/// One row for every kind of body and flow of usable cases at rest, variants of the numerics left out.
std::vector<MeshRow> mesh_rows(const std::vector<case_record::CaseRecord>& records);

std::string render(const std::vector<MeshRow>& rows, Format format, bool colour = false);
nlohmann::json to_json(const std::vector<MeshRow>& rows);

/// Whether u_disc holds: the finest mesh of every pose with three or more, held against what the meshes before it said of their own u. A
/// share is the distance of the two values of C_D over 2u, below 1 if the uncertainty of 95 % holds; of second order, and with no safety
/// factor, it would be 1/2.
struct HeldBackRow {
  std::string rule, flow;  ///< "two meshes, factor 3", or "three or more" and the safety factor; flow model
  int poses = 0, within = 0;
  double median = 0.0, largest = 0.0;
  std::string worst;  ///< the pose of `largest`, with both values
};
std::vector<HeldBackRow> held_back_rows(const std::vector<case_record::CaseRecord>& records);

std::string render(const std::vector<HeldBackRow>& rows, Format format, bool colour = false);
nlohmann::json to_json(const std::vector<HeldBackRow>& rows);

}  // namespace compare
