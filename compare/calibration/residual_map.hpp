#pragma once

#include <Eigen/Core>
#include <array>
#include <dragcore/drag.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/calibration/calibration.hpp"

namespace compare {

/// Force and moment of one body in one pose, in coefficients of the surface: over density/2 speed^2 total_area, moments also over radius
/// and about Surface::centre.
struct PoseLoad {
  using Channels = case_record::CaseRecord::Channels;
  std::string name;
  Eigen::Matrix3d to_wind = Eigen::Matrix3d::Identity();   ///< from the body's frame; the wind blows along +x of the wind frame
  Channels load = Channels::Zero(), u = Channels::Zero();  ///< wind frame, with standard uncertainty
  std::array<bool, 6> known{};

  Eigen::Vector3d direction() const { return to_wind.row(0).transpose(); }  ///< of the air, body frame
};

/// One body with what is known of it, all at one Reynolds number.
struct BodyLoads {
  const dragcore::Surface* surface = nullptr;
  std::vector<Eigen::Matrix3d> group;  ///< symmetry_group() of its mesh
  double reference_length = 1.0;       ///< of the errors of moments and of `reynolds` [m]
  double reynolds = 1e5;
  std::vector<PoseLoad> poses;
};

/// @param records  usable cases of one body at rest, at one Reynolds number, with their uncertainty
BodyLoads body_loads(const dragcore::Surface& surface, const std::vector<Eigen::Matrix3d>& group,
                     const std::vector<std::pair<case_record::CaseRecord, case_record::CaseRecord::Channels>>& records);

/// A smooth vector field over the sphere of directions that goes with a body's symmetry, known from observations: a Gaussian process with
/// the kernel
///
///   K(d, d') = a^2/c sum_g exp(-(1 - d . g d')/l^2) rho(g),    rho(g) = g for forces, det(g) g for torques
///
/// over the symmetry group, with c such that a is its standard deviation. Every sample of it has the symmetry exactly: f(g d) = rho(g)
/// f(d), so that poses count as often as the body is symmetric, and what symmetry says is zero is.
class DirectionField {
 public:
  struct Observation {
    Eigen::Vector3d direction, axis;  ///< axis . field(direction) = value
    double value, u;
    int pose;  ///< what belongs together is left out together
  };
  struct Kernel {
    double length = 0.7;  ///< l: chord over which it changes
    double size = 1.0;    ///< a
  };
  DirectionField(std::vector<Observation> observations, const std::vector<Eigen::Matrix3d>& group, bool axial, const Kernel& kernel);

  Eigen::Vector3d mean(const Eigen::Vector3d& direction) const;
  double spread(const Eigen::Vector3d& direction) const;  ///< standard deviation, root of the trace
  /// value minus what the field would be there had it not seen the pose; in the order of the observations.
  Eigen::VectorXd left_out_residuals() const;

 private:
  Eigen::Matrix3d covariance(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;
  Eigen::MatrixXd to_observations(const Eigen::Vector3d& direction) const;

  std::vector<Observation> observations_;
  const std::vector<Eigen::Matrix3d>* group_;
  bool axial_;
  Kernel kernel_;
  double norm_ = 1.0;
  Eigen::MatrixXd inverse_;
  Eigen::VectorXd weights_;
};

/// Errors over poses: of force and moment, as length of the difference over the larger of the force and 0.3 of the mean force (a moment's
/// also over reference_length), and of C_D alone over the same.
struct PoseErrors {
  double mean_force = 0.0, worst_force = 0.0, mean_drag = 0.0, worst_drag = 0.0, mean_moment = 0.0, worst_moment = 0.0;
  int poses = 0, moments = 0;  ///< over so many; so many of them know their moment
};

struct ModelErrors {
  std::string model;
  PoseErrors seen;                   ///< over the poses that were fitted to
  std::optional<PoseErrors> unseen;  ///< each pose by a fit, choices included, that has not seen it; empty of what was not fitted
};

struct ResidualFit {
  dragcore::Model model;                    ///< the law by class, its pillow, and the correction
  std::optional<Estimate> pillow;           ///< factor of the tilt form from this body's moments; empty where no moment tells
  std::vector<ModelErrors> errors;          ///< note's law, class law, class law with fitted pillow, residual map
  std::string force_choice, moment_choice;  ///< "correction of the law, length 0.7", "map without the law, ...", "the law alone"
  double mean_u = 0.0;                      ///< of the references, unit of PoseErrors::mean_force
  DirectionField force;                     ///< of what was chosen
  double force_length = 0.7;                ///< of its kernel
  const ModelErrors& map() const { return errors.back(); }
};

/// Fits a pillow factor to the moments, and a correction to the class law; or a map without the law, in the place of which the mean drag
/// along the wind stands: what is left out pose by pose decides, for force and moment each by itself, as it does on the kernel's length and
/// size, and on no correction at all. All these choices are made again without each pose for the errors on unseen ones.
/// @throws std::invalid_argument  fewer than three poses that know their whole force
ResidualFit fit_residual_map(const BodyLoads& body, const std::string& origin);

/// Errors of a model on poses.
PoseErrors pose_errors(const BodyLoads& body, const std::vector<PoseLoad>& poses, const dragcore::Model& model);

/// Poses where a field is least sure, one after the other, given those that are known: spread over all directions, modulo symmetry. Within
/// 10 degrees of a mirror plane they are put on it, where a CFD case needs half of the cells.
/// @param among  where not empty, chosen from these alone
std::vector<Eigen::Vector3d> next_directions(const std::vector<Eigen::Vector3d>& known, const std::vector<Eigen::Matrix3d>& group,
                                             double length, int count, const std::vector<Eigen::Vector3d>& among = {});

/// A pose with the wind along this direction of the body, in tenths of a degree; a mirror plane that holds the wind stands upright in it.
dragcore::Pose pose_towards(const Eigen::Vector3d& direction, const std::vector<Eigen::Matrix3d>& group);

}  // namespace compare
