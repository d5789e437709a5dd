#pragma once

#include <Eigen/Core>
#include <dragcore/surface.hpp>
#include <string>

namespace dragcore {

/// The pillow effect: air that has met the leading part of a face cushions the trailing part, so that the force acts ahead of the centroid.
/// Every form displaces the points where the pressure acts, and never changes the size of the force; only windward pressure is displaced.
enum class PillowForm {
  none,
  triangle,      ///< the note's: circular falloff measured over each triangle. Depends on the triangulation (erratum E13)
  patch,         ///< circular falloff measured over the connected planar patch: does not depend on the triangulation
  tilt,          ///< falloff 1 - factor * t (2 s - 1) over the patch, t the tangential fraction: vanishes at normal incidence by itself
  eccentricity,  ///< the note's shortcut (erratum E12): `triangle` along the flow, but across it the vector from centroid to incentre,
                 ///< whatever the factor. Jumps at normal incidence. For the record only
};

/// How the cushion grows from the leading edge of a face, s = 0, to its trailing edge, s = 1. For the forms `triangle` and `patch`.
enum class Falloff {
  circular,  ///< the note's: f = factor sqrt(1 - s^2) + 1 - factor; cannot move the force ahead of 0.424 of the chord
  linear,    ///< f = 1 - factor s; reaches a third of the chord
};

/// Of kappa of the tilt form: beyond, its falloff would be negative on half of a face.
inline constexpr double largest_tilt = 1.5;

struct Pillow {
  PillowForm form = PillowForm::none;
  double factor = 0.0;  ///< the note's alpha in [0, 1], or kappa of the tilt form in [0, largest_tilt]
  Falloff falloff = Falloff::circular;
  /// Of the tilt form where the viscosity is known and the law has viscous terms: kappa = min(1.5, factor + gain/sqrt(Re_l)), Re_l that of
  /// the flow at the part's centre (Law). Without a factor there is no pillow, whatever the gain.
  double viscous_gain = 0.0;

  bool operator==(const Pillow&) const = default;
};

std::string to_string(PillowForm form);
PillowForm pillow_form_from(const std::string& word);  ///< @throws std::invalid_argument with the known words

std::string to_string(Falloff falloff);
Falloff falloff_from(const std::string& word);  ///< @throws std::invalid_argument with the known words

/// A falloff over a triangle whose vertices lie at s = 0, beta, 1 along the flow.
/// Returns the barycentric weights (first, middle, last) of the point where the force acts: all in (0, 1), sum 1, for every beta in [0, 1].
/// Accuracy 1e-14. @source [toskan2020] sec. 2.1, in the form of docs/model.md, which has no axes and no singular case.
Eigen::Vector3d triangle_pillow_weights(double beta, double alpha, Falloff falloff = Falloff::circular);

/// Displacement from the centroid of a triangle to the point where its pressure acts, for air that moves with velocity u relative to it
/// [m]. Zero where u has no tangential part, and for a triangle seen end-on along the flow.
Eigen::Vector3d triangle_pillow_shift(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                      const Eigen::Vector3d& u, double alpha, Falloff falloff = Falloff::circular);

/// The note's shortcut for the same: along the flow as above, across it by the part of (incentre - centroid) that lies there.
Eigen::Vector3d eccentricity_pillow_shift(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                          const Eigen::Vector3d& u, double alpha);

/// The same over a planar patch, s measured from its leading to its trailing edge along the flow: exact integrals over the outline, so that
/// the triangles inside do not matter. Accuracy 1e-13 of the chord.
Eigen::Vector3d patch_pillow_shift(const Patch& patch, const Eigen::Vector3d& u, double alpha, Falloff falloff = Falloff::circular);

/// The tilt form: -kappa t M2 e / sqrt(3 e.M2 e), with e the direction of the flow over the face, t its tangential fraction |u_t|/|u|, and
/// M2 the second moment per area of the triangle's region (Surface::second_moment). sqrt(12 e.M2 e) is the chord of a rectangle along its
/// sides. Tangential to `normal`; 0 where the flow has no direction over the face.
Eigen::Vector3d tilt_pillow_shift(const Eigen::Vector3d& normal, const Eigen::Matrix3d& second_moment, const Eigen::Vector3d& u,
                                  double kappa);

/// The note's factor, faded out towards normal incidence where the flow over the face has no direction: alpha * smoothstep((1 - c) / 0.25).
double faded_pillow_factor(double alpha, double c);

}  // namespace dragcore
