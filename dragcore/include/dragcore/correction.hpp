#pragma once

#include <dragcore/direction_map.hpp>
#include <dragcore/surface.hpp>
#include <limits>
#include <optional>
#include <string>

namespace dragcore {

/// What one body was found to feel, by CFD or in a wind tunnel, beyond what a law says: eq. 18 of docs/model.md.
///
///   F += s d rho/2 |u|^2 A f(u/|u|),   T += s d rho/2 |u|^2 A L m(u/|u|)     about Surface::centre, where u is taken
///
/// with A = Surface::total_area and L = Surface::radius, so that it goes with the density, the square of the speed and the size of a
/// body. d = |u|^2/(|u|^2 + (variation L)^2) fades it as spin, or a wind that varies, takes over from the one direction of flow. s keeps it
/// passive: what it gives the body of energy is held below `largest_gain` of what the law takes, as the pushing terms of a law are, by the
/// same smooth share (eq. 13). So a body with a correction keeps at least a twentieth of the law's dissipation in every motion.
///
/// It is added once a call, on top of whatever sums the triangles; none where the model has none.
struct Correction {
  DirectionMap map;  ///< f and m: 1 row a node
  /// Of the surface it was found on; another one is refused, but for its size and its triangulation. Empty: any will do.
  std::optional<ShapeMoments> body{};
  /// Found in a medium whose viscosity the law was told: without it the law is another, and is refused.
  bool viscous = false;
  double least_reynolds = 0.0;  ///< on the diameter 2 radius, where it was found: validity() says where a motion is elsewhere
  double most_reynolds = std::numeric_limits<double>::infinity();
  std::string origin;  ///< what it was found from, for people
};

/// Largest difference of shape moments that rounding of coordinates, STL files' among them, and other facets of a flat or a finely cut
/// face make. Bodies that differ by less are the same to the air.
inline constexpr double same_body = 1e-3;

/// @throws std::invalid_argument  a map that is not whole or not of one row a node, a number that is not finite, a range of Re that is none
void validate(const Correction& correction);

}  // namespace dragcore
