#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <dragcore/mesh.hpp>
#include <memory>
#include <string>
#include <vector>

namespace dragcore {

/// One thing that preparation found in a mesh, with what it did about it.
struct Finding {
  enum class Kind {
    welded,        ///< corners a hair apart were joined, which closed gaps
    degenerate,    ///< triangles without area: they carry no force
    duplicate,     ///< triangles that the file says more than once, whatever their winding: one of each is kept
    reversed,      ///< triangles wound against their neighbours, turned
    inside_out,    ///< closed shells with normals pointing inwards, turned
    capped,        ///< holes of a body, closed by lids that feel the wind
    sheet,         ///< shells without thickness: both sides feel the air
    open_through,  ///< shells that one can look through, a tube or a ring: left open, taken as sheets
    hidden,        ///< triangles that no wind reaches, left out
    covered,       ///< triangles of which other parts cover a share
    non_manifold,  ///< edges of more than two triangles
    joined,        ///< shells that touch or overlap, taken as one body
  };
  Kind kind;
  int count = 0;      ///< of triangles, edges, holes or shells, as the kind says
  double area = 0.0;  ///< concerned [m^2]
  std::string text;   ///< a sentence for people
};

std::string to_string(Finding::Kind kind);

/// How much of every triangle the wind reaches, from a set of directions; made by dragcore::exposure (expose.hpp).
/// Between the directions it is interpolated linearly over the cells that they span on the unit sphere, so that no force jumps.
struct Exposure {
  /// A triangle of three directions. It is whole, or cut into two to four that together cover it.
  struct Cell {
    Eigen::Vector3i corner = Eigen::Vector3i::Zero();
    int child = 0, children = 0;  ///< the cells that it is cut into follow each other
  };
  std::vector<Eigen::Vector3d> directions;  ///< unit, from the body to where the wind comes from
  std::vector<Cell> cells;                  ///< the first 20, of an icosahedron, cover the sphere; no whole cell has a corner on its edge
  std::vector<int> row;                     ///< of every triangle in `reached`: those of fine meshes share one with their neighbours
  Eigen::Array<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic> reached;  ///< share of row from direction (column), 0 to 255
  /// What half-way between directions the windward area that is reached may be wrong by, as a share of it: the largest error among those
  /// looked at, which are where the shadows change fastest. 0 where nothing was looked at.
  double residual = 0.0;

  /// The corners of the cell that a direction falls into, and their weights; not negative, sum 1.
  struct Sample {
    Eigen::Vector3i corner = Eigen::Vector3i::Zero();
    Eigen::Vector3d weight = Eigen::Vector3d::UnitX();
  };
  Sample towards(const Eigen::Vector3d& direction) const;
  double share(Eigen::Index triangle, const Sample& sample) const {
    const int own = row[static_cast<std::size_t>(triangle)];
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) sum += sample.weight[k] * reached(own, sample.corner[k]);
    return sum / 255.0;
  }
};

/// The piece of a triangle that some wind reaches, where that is not all of it.
struct WettedPiece {
  double front = 1.0, back = 1.0;                      ///< share of the area, by side; `back` counts on sheets only
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< of that piece [m]
};

/// A mesh made ready to be a body: what Surface is made of. Nothing is moved but corners that were joined.
struct Preparation {
  TriangleMesh mesh;            ///< triangles in the order of the input, then the lids; bodies wound outwards
  std::vector<int> part;        ///< of every triangle, numbered from 0: a body or sheet by itself, which has its own class and law
  std::vector<bool> sheet;      ///< of every part: both sides feel the air
  std::vector<bool> lid;        ///< of every triangle: made here, to close a hole
  std::vector<Finding> report;  ///< everything that was found; empty for a clean closed mesh

  // By expose() only; empty where the wind reaches everything.
  std::vector<WettedPiece> wetted;           ///< of every triangle
  std::shared_ptr<const Exposure> exposure;  ///< of every triangle
  bool exposed = false;                      ///< rays were cast: `wetted` and `exposure` are known, if only to be empty

  int parts() const { return static_cast<int>(sheet.size()); }
  bool found(Finding::Kind kind) const;
};

/// From triangles as files have them to bodies and sheets:
///   1. corners are joined that lie within 1e-3 of the local edge, or a few steps of single precision, of each other, where that closes
///      open edges; of edges that three triangles share it may make a quarter as many, where bodies touch or a fin stands on one;
///   2. a triangle said twice counts once;
///   3. triangles that share an edge are one shell; where more than two meet, those go on into each other that turn least;
///   4. within a shell all are wound alike, and outwards as its own volume says;
///   5. holes are capped by lids; a shell that stays thin when capped (mean thickness below 0.12 of its middle extent) and whose lids are
///      more than a fifth of its area is a sheet, and so is one whose holes one can look through;
///   6. what lies wholly inside a closed shell feels no wind and is left out.
/// Walls that are hidden in other ways, and what stands in whose wind, take rays: dragcore::exposure.
/// @throws std::invalid_argument  as validate(mesh)
/// @cost   0.6 s for a million triangles
Preparation prepare(const TriangleMesh& mesh);

/// A line for each finding.
std::string describe(const std::vector<Finding>& report);

}  // namespace dragcore
