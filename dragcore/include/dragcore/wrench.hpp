#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

namespace dragcore {

/// Force [N] and torque [N m] about a stated point.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();

  Wrench& operator+=(const Wrench& other) {
    force += other.force;
    torque += other.torque;
    return *this;
  }
};

/// What a part of the wrench is caused by.
enum class Term {
  windward_pressure,  ///< W, sheltered
  leeward_suction,    ///< L
  base_suction,       ///< B, felt on windward faces in the law's gauge
  rear_recovery,      ///< on leeward faces: pushes upstream
  curvature,          ///< suction on windward faces that curve along the flow
  friction,           ///< and all that is viscous: the boundary layer, and Stokes' resistance with the pressure it has a share of
  correction,         ///< what this body was found to feel beyond its law: Correction
  count
};

std::string to_string(Term term);

/// A wrench split by cause, so that an error can be traced to its culprit.
struct WrenchByTerm {
  std::array<Wrench, static_cast<std::size_t>(Term::count)> terms;

  Wrench& operator[](Term term) { return terms[static_cast<std::size_t>(term)]; }
  const Wrench& operator[](Term term) const { return terms[static_cast<std::size_t>(term)]; }
  Wrench total() const {
    Wrench sum;
    for (const Wrench& term : terms) sum += term;
    return sum;
  }
};

}  // namespace dragcore
