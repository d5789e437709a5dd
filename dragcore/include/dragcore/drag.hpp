#pragma once

#include <dragcore/correction.hpp>
#include <dragcore/effects.hpp>
#include <dragcore/law.hpp>
#include <dragcore/pillow.hpp>
#include <dragcore/surface.hpp>
#include <dragcore/wrench.hpp>
#include <memory>
#include <optional>
#include <span>

namespace dragcore {

/// Rigid motion of a body and the air around it, all in the body frame.
struct Motion {
  Eigen::Vector3d wind = Eigen::Vector3d::Zero();              ///< velocity of the undisturbed air at `reference_point` [m/s]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          ///< of the body at `reference_point` [m/s]
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< [rad/s]
  Eigen::Vector3d reference_point =
      Eigen::Vector3d::Zero();  ///< where `velocity` holds and about which torque is taken; the centre of mass, say [m]
  Eigen::Matrix3d wind_gradient = Eigen::Matrix3d::Zero();  ///< (i, j) = d wind_i / d x_j [1/s]
  /// Wind at the centroid of every triangle of the surface, in its order, in place of `wind` and `wind_gradient`; not owned. Empty: not
  /// used [m/s]. body_wind.hpp fills these three from a wind field.
  std::span<const Eigen::Vector3d> triangle_wind{};
};

struct Medium {
  double density = 1.225;  ///< [kg/m^3]
  /// Dynamic, 1.8e-5 of air at 15 C [Pa s]. 0: not known, and no force depends on it; else the viscous terms of a Law take the place of its
  /// constant friction, and one law holds from creeping flow to Re 1e5.
  double viscosity = 0.0;
};

/// Points per triangle where the local velocity is taken: the centroid; three inside, exact to degree 2; six, exact to degree 4.
/// `adaptive` takes one, three or six by how much the velocity varies over the triangle, |omega| r / |u| for spin: one below 0.002, three
/// from 0.004 to 0.5, six above 1, and a smooth blend between, so that no force jumps.
enum class Quadrature { adaptive = 0, one = 1, three = 3, six = 6 };

/// What parts of class `sheet` have in place of a model's law and pillow.
struct SheetModel {
  Law law = note_law();
  Pillow pillow{};
};

/// Of the sum over the triangles. `single` runs 8 or 16 triangles at once where the library was built with its kernels (DRAGCORE_SIMD) and
/// they know the model: all but the pillow forms other than `tilt` and laws whose polynomials change sign. Else it is `full`.
enum class Precision {
  full,    ///< double throughout: within 1e-12 of reference::wrench()
  single,  ///< float within a block of triangles, double between blocks: within 1e-6 of density/2 speed^2 times the area of both sides.
           ///< Where little of that is felt, a sheet edge-on, the error is as large and the force is not: 1e-5 of it there
};

/// A plain Model is the note's: no friction, no pillow. model_for() has what validation found best.
struct Model {
  Law law = note_law();
  Pillow pillow{};
  Quadrature quadrature = Quadrature::three;
  Effects effects = Effects::all();
  /// Refuses input that is not finite or out of range, and results that are not finite. Without it such values pass through to the result.
  bool check = true;
  /// Of parts of class `sheet`, where a mesh has both sheets and bodies. Empty: as the others.
  std::optional<SheetModel> sheets{};
  Precision precision = Precision::full;
  /// What one body was found to feel beyond the law, of a calibration (calibrated_file.hpp). Null: nothing is known.
  std::shared_ptr<const Correction> correction{};

  const Law& law_of(BodyClass body_class) const { return sheets && body_class == BodyClass::sheet ? sheets->law : law; }
  const Pillow& pillow_of(BodyClass body_class) const { return sheets && body_class == BodyClass::sheet ? sheets->pillow : pillow; }
};

/// Of what dissipating terms take, the share that terms pushing the body through the air may give back: eq. 13 of docs/model.md.
inline constexpr double largest_gain = 0.95;

/// Force and torque of the air on a rigid surface, by the local pressure law integrated over each triangle.
///
///   u(r) = wind + G (r - r0) - V - omega x (r - r0),  w = -u.n,  c = |w|/|u|,  q = rho |u|^2/2
///   dF = -n q W(c) dA  where w > 0,      dF = n q L(c) dA  where w < 0            (docs/model.md, eq. 1-3; further terms: Law, eq. 7-12)
///
/// Where the medium has a viscosity and the law its terms, eq. 15 to 17 too: linear in u as Re -> 0, exact there for ellipsoids.
///
/// The pillow effect displaces each point by the shift of its triangle or patch before u is taken there, so that every point is still
/// passive: relative to the air, no motion and no law can gain energy. Terms of a law that push are scaled down together where they would.
/// Stateless: a hypothetical motion may be tried at any time, and from any thread.
///
/// @return        force [N], torque about `motion.reference_point` [N m], body frame, by term. Zero for an empty surface and where u = 0
/// @throws std::invalid_argument  if density or viscosity is negative, the pillow factor is out of range, the law is not valid, `triangle_wind` has not
/// one entry per
///                                triangle, or anything is not finite: value found, value needed (unless Model::check is off)
/// @accuracy      within 1e-12 of reference::wrench (tests/dragcore/drag/test_drag.cpp), or 1e-6 of density/2 speed^2 area in
/// Precision::single
///                (tests/dragcore/kernels/test_wrench_kernel.cpp); one point per triangle is exact for motion without spin
/// @source        [toskan2020] sec. 2 and 2.1; differs: leeward faces never feel windward pressure, spin by quadrature instead of a
/// separate law
WrenchByTerm wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model);

/// Force [N] of every triangle of a surface, and its torque about `motion.reference_point` [N m]; 3 x n, in the surface's order, body
/// frame.
struct TriangleForces {
  Eigen::Matrix3Xd force, torque;
};

/// The parts whose sums are wrench(...).total() to the rounding of its precision; always in double themselves: for deforming bodies, for
/// drawing, for finding where a load comes from. A correction knows no triangles: it is spread as a traction that is linear in place.
/// @throws std::invalid_argument  as wrench()
TriangleForces triangle_forces(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model);

/// The one line along which a force alone would do what a wrench does, but for a torque along it.
struct LineOfAction {
  Eigen::Vector3d point;      ///< of the line, nearest to the reference point [m]
  Eigen::Vector3d direction;  ///< of the force, unit
  double couple;              ///< torque along the direction that no force on the line can make [N m]
};

/// @param reference_point  about which `wrench.torque` is taken
/// @return                 empty where there is no force
std::optional<LineOfAction> line_of_action(const Wrench& wrench, const Eigen::Vector3d& reference_point);

/// Centre of pressure: where the line of action pierces a plane of the body, the chord plane of a wing, say.
/// @return  empty where the force lies within 3 degrees of the plane: the cut is then ill-conditioned
std::optional<Eigen::Vector3d> centre_of_pressure(const LineOfAction& line, const Eigen::Vector3d& plane_point,
                                                  const Eigen::Vector3d& plane_normal);

/// The tilt pillow that goes with a class: kappa 0.86 for sheets, 0.5 for closed bodies, both with a gain of 5.9 where the viscosity is
/// known: at Re 100 it takes the mean moment error of 15 poses of sheets from 0.044 to 0.004, of 24 of closed bodies from 0.024 to 0.016,
/// of force times length. `dragval calibrate` says what the present
/// references make of them, and how surely.
Pillow class_pillow(BodyClass body_class);

/// law_for() and class_pillow() of the surface's classes, sheets and bodies apart where it has both: what validation found best. See README
/// for its errors. In single precision, whose error is a ten-thousandth of the law's.
Model model_for(const Surface& surface);

namespace reference {

/// The same, written to be read next to the equations: no prepared structures, no shortcuts. The yardstick of everything fast.
WrenchByTerm wrench(const TriangleMesh& mesh, Surface::Sides sides, const Motion& motion, const Medium& medium, const Model& model);

}  // namespace reference

}  // namespace dragcore
