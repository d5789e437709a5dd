#pragma once

#include <dragcore/law.hpp>
#include <dragcore/pillow.hpp>
#include <dragcore/surface.hpp>
#include <dragcore/wrench.hpp>

namespace dragcore {

/// Rigid motion of a body and the air around it, all in the body frame.
struct Motion {
  Eigen::Vector3d wind = Eigen::Vector3d::Zero();              ///< velocity of the undisturbed air [m/s]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          ///< of the body at `reference_point` [m/s]
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< [rad/s]
  Eigen::Vector3d reference_point = Eigen::Vector3d::Zero();   ///< where `velocity` holds and about which torque is taken; the centre of mass, say [m]
};

struct Medium {
  double density = 1.225;  ///< [kg/m^3]
};

/// Points per triangle where the local velocity is taken: the centroid; three inside, exact to degree 2; six, exact to degree 4.
enum class Quadrature { one = 1, three = 3, six = 6 };

struct Model {
  Law law = note_law();
  Pillow pillow{};
  Quadrature quadrature = Quadrature::three;
};

/// Force and torque of the air on a rigid surface, by the local pressure law integrated over each triangle.
///
///   u(r) = wind - V - omega x (r - r0),  w = -u.n,  c = |w|/|u|,  q = rho |u|^2/2
///   dF = -n q W(c) dA  where w > 0,      dF = n q L(c) dA  where w < 0            (docs/model.md, eq. 1-3)
///
/// The pillow effect displaces each point by the shift of its triangle or patch before u is taken there, so that every point is still
/// passive: in still air the power of a law with W, L >= 0 is never positive.
///
/// @return        force [N], torque about `motion.reference_point` [N m], body frame, by term. Zero for an empty surface and where u = 0
/// @throws std::invalid_argument  if density is negative, the pillow factor is out of range or anything is not finite: value found, value needed
/// @accuracy      within 1e-12 of reference::wrench (tests/dragcore/test_drag.cpp); one point per triangle is exact for motion without spin
/// @source        [toskan2020] sec. 2 and 2.1; differs: leeward faces never feel windward pressure, spin by quadrature instead of a separate law
WrenchByTerm wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model);

namespace reference {

/// The same, written to be read next to the equations: no prepared structures, no shortcuts. The yardstick of everything fast.
WrenchByTerm wrench(const TriangleMesh& mesh, Surface::Sides sides, const Motion& motion, const Medium& medium, const Model& model);

}  // namespace reference

}  // namespace dragcore
