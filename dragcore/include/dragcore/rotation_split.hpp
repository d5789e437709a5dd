#pragma once

#include <dragcore/drag.hpp>

namespace dragcore {

/// How the note treats spin: drag of the motion of each triangle's centroid, plus drag of the rotation about that centroid, computed apart
/// and added. Kept so that its error and cost can be shown beside quadrature (docs/model.md, E25): a quadratic force misses its cross term
/// this way.
struct RotationSplit {
  enum class Formulas {
    mended,   ///< closed-form integrals of the local law about the centroid, tilt and net force included
    printed,  ///< the note's integrals as they stand, errata E14-E23 and all, by numerical integration. For the record only
  };
  Formulas formulas = Formulas::mended;
  double leeward_share = 0.0;  ///< of the windward pressure that the side moving inwards feels as suction; the note: 1, a closed body: 0
};

/// Wrench of the note's own law (c^2 (2 - c), no pillow) by the split. Term::windward_pressure holds both parts.
/// Not passive: in still air the sum may add energy. @throws std::invalid_argument as wrench() does
WrenchByTerm rotation_split_wrench(const Surface& surface, const Motion& motion, const Medium& medium, const RotationSplit& split);

/// The rotational part alone for one triangle spinning about its centroid: force, and torque about the centroid.
///   F = -k N (m_w - share m_l),  M = sum_i (q_w - share q_l)_i (P_i - G) x (-k N),  k = rho (1 - s/2),  s = |N x omega| / |omega|
/// with m and q the integrals of v_n^2 and v_n^2 lambda_i over the parts that move outwards and inwards.
Wrench rotating_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& omega,
                         double density, double leeward_share);

}  // namespace dragcore
