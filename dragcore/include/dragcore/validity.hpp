#pragma once

#include <dragcore/drag.hpp>
#include <string>
#include <vector>

namespace dragcore {

/// A reason to doubt a force.
enum class Doubt : unsigned {
  /// Below Re 1e4, to which the laws were fitted: friction and wakes differ. Where the medium has a viscosity and the law its terms: from
  /// Re 200 to 1e4, where a ball is 10 to 33 % too draggy.
  low_reynolds = 1u << 0,
  not_exposed = 1u << 1,   ///< walls may stand in each other's wind, and nobody looked: expose()
  concave = 1u << 2,       ///< not one convex body, to which the laws are fitted
  spin = 1u << 3,          ///< points move faster by spin than by travel: torques of spin are 15 to 65 % low
  stalling_sheet =
      1u << 4,  ///< a sheet between 17 and 48 degrees of incidence, where steady RANS, which the law is fitted to, is a quarter low
  edge_on_sheet = 1u << 5,  ///< a sheet within 5 degrees of edge-on: edge and friction, which the law has not
  elongated = 1u << 6,      ///< a body more than 1.8 times as long as wide, 3 to 22 degrees from its axis: reattachment on its sides
  smooth_body = 1u << 7,    ///< a round body: where it separates, the law does not know; and near its drag crisis nobody does
  uneven_wind = 1u << 8,    ///< the wind varies over the body by more than a third of the speed
  drag_crisis = 1u << 9,    ///< a round body above Re 2e5 in a medium of known viscosity: its drag may fall to a quarter
  not_calibrated = 1u << 10,  ///< the model has a correction that was found at a Reynolds number more than a factor of three away
};

/// Whether a force is within what the model was fitted to, and why not.
struct Validity {
  unsigned doubts = 0;               ///< bits of Doubt
  std::vector<std::string> reasons;  ///< a sentence for each

  bool in_range() const { return doubts == 0; }
  bool has(Doubt doubt) const { return (doubts & static_cast<unsigned>(doubt)) != 0; }
};

std::string to_string(Doubt doubt);

/// What is known of the laws by class, sheet_law() and closed_law(), in this flow. Each doubt is judged for the part with the largest area.
/// How often it is right: `dragval compare` prints that beside its tables.
/// @param viscosity  dynamic, where the medium does not say [Pa s]; 0 leaves the Reynolds number, on the diameter 2 * radius, out of it
/// @throws std::invalid_argument  as wrench()
Validity validity(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model, double viscosity = 1.8e-5);

}  // namespace dragcore
