#include "compare/calibration/residual_map.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <stdexcept>

#include "compare/calibration/prediction.hpp"
#include "compare/calibration/symmetry.hpp"
#include "compare/reference/coefficients.hpp"

namespace compare {

namespace {

using case_record::CaseRecord;
using Channels = CaseRecord::Channels;
using dragcore::Surface;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double least_share_of_force = 0.3;
constexpr std::array lengths{0.35, 0.5, 0.7, 1.0, 1.4};
constexpr std::array sizes{0.5, 1.0, 2.0};  // of what is left by the prior, rms
/// Of the force: what poses scatter by beside their u. At Re 1e5 steady RANS does by 3 to 6 %, at Re 100 not.
constexpr std::array scatters{0.01, 0.04};
/// A map must leave less than this share of the law's error. Of few poses some map always looks a little better: on the stored cone at Re
/// 100 that cost up to 27 % in the poses left, and none of the larger gains is lost by it (dragval calibrate --stored).
constexpr double least_gain = 0.8;
constexpr double kappa_step = 0.05;
constexpr int kappas = 31;  // 0 to 1.5
/// Cells of the octahedron's edges, 6 to 9 degrees: two to three of the shortest length.
constexpr int map_frequency = 12;

std::vector<Vector3d> spiral(int count) {
  std::vector<Vector3d> list;
  for (int k = 0; k < count; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / count, angle = k * std::numbers::pi * (3.0 - std::sqrt(5.0)), r = std::sqrt(1.0 - z * z);
    list.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return list;
}

/// The law at a wind of 1 m/s along a direction, in coefficients of the surface, body frame, about its centre.
Channels coefficients_of(const BodyLoads& body, const dragcore::Model& model, const Vector3d& direction) {
  const Surface& surface = *body.surface;
  dragcore::Medium medium{.density = 2.0 / surface.total_area};
  // Above, maps are to be baked, which know no viscosity, and the law's friction is a constant.
  if (body.reynolds < 1e4) medium.viscosity = medium.density * body.reference_length / body.reynolds;
  const dragcore::Wrench w = wrench(surface, {.wind = direction, .reference_point = surface.centre}, medium, model).total();
  return (Channels() << w.force, w.torque / surface.radius).finished();
}

dragcore::Model with_pillow(dragcore::Model model, double factor) {
  model.pillow.factor = factor;
  if (model.sheets) model.sheets->pillow.factor = factor;
  return model;
}

/// By pose: where it cannot be told from another by symmetry, both are one.
std::vector<int> orbits(const BodyLoads& body) {
  std::vector<int> orbit;
  for (std::size_t i = 0; i < body.poses.size(); ++i) {
    int found = static_cast<int>(i);
    for (std::size_t j = 0; j < i && found == static_cast<int>(i); ++j)
      for (const Matrix3d& g : body.group)
        if ((g * body.poses[j].direction() - body.poses[i].direction()).norm() < 0.02) found = orbit[j];
    orbit.push_back(found);
  }
  return orbit;
}

bool knows(const PoseLoad& pose, int first) {
  return pose.known[static_cast<std::size_t>(first)] && pose.known[static_cast<std::size_t>(first) + 1] &&
         pose.known[static_cast<std::size_t>(first) + 2];
}

/// What errors are divided by: of every pose.
std::vector<double> scales(const std::vector<PoseLoad>& poses) {
  double mean = 0.0;
  for (const PoseLoad& pose : poses) mean += pose.load.head<3>().norm() / static_cast<double>(poses.size());
  std::vector<double> list;
  for (const PoseLoad& pose : poses) list.push_back(std::max(pose.load.head<3>().norm(), least_share_of_force * mean));
  return list;
}

/// What is predicted of every pose, wind frame.
using Predicted = std::vector<Channels>;

PoseErrors errors_of(const BodyLoads& body, const std::vector<PoseLoad>& poses, const std::vector<double>& scale,
                     const Predicted& predicted) {
  PoseErrors errors;
  const double arm = body.surface->radius / body.reference_length;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Channels off = predicted[i] - poses[i].load;
    const auto add = [](double error, double& mean, double& worst) { mean += error, worst = std::max(worst, error); };
    // A pose whose whole force nobody knows has a drag to be wrong by.
    add((knows(poses[i], 0) ? off.head<3>().norm() : std::abs(off[0])) / scale[i], errors.mean_force, errors.worst_force);
    add(std::abs(off[0]) / scale[i], errors.mean_drag, errors.worst_drag);
    if (knows(poses[i], 3)) add(arm * off.tail<3>().norm() / scale[i], errors.mean_moment, errors.worst_moment), ++errors.moments;
  }
  errors.poses = static_cast<int>(poses.size());
  errors.mean_force /= std::max(1, errors.poses), errors.mean_drag /= std::max(1, errors.poses),
      errors.mean_moment /= std::max(1, errors.moments);
  return errors;
}

Channels in_wind(const PoseLoad& pose, const Channels& body_frame) {
  return (Channels() << pose.to_wind * body_frame.head<3>(), pose.to_wind * body_frame.tail<3>()).finished();
}

Predicted predicted_by(const BodyLoads& body, const std::vector<PoseLoad>& poses, const dragcore::Model& model) {
  Predicted list;
  for (const PoseLoad& pose : poses) list.push_back(in_wind(pose, coefficients_of(body, model, pose.direction())));
  return list;
}

/// The law's loads in every pose at each pillow factor: all that a fit needs of the model.
struct LawTable {
  std::vector<Predicted> at;  ///< by factor, then pose; wind frame
  std::vector<double> scale;
  std::vector<int> orbit;

  explicit LawTable(const BodyLoads& body) : scale(scales(body.poses)), orbit(orbits(body)) {
    const dragcore::Model law = dragcore::model_for(*body.surface);
    for (int k = 0; k < kappas; ++k) at.push_back(predicted_by(body, body.poses, with_pillow(law, k * kappa_step)));
  }

  Channels law(std::size_t pose, double kappa) const {
    const double place = kappa / kappa_step;
    const auto low = std::min(static_cast<std::size_t>(place), static_cast<std::size_t>(kappas - 2));
    const double rest = place - static_cast<double>(low);
    return (1.0 - rest) * at[low][pose] + rest * at[low + 1][pose];
  }
};

/// Least squares of the moments over some poses, by a parabola through the best of the table. Empty without moments.
std::optional<double> best_kappa(const BodyLoads& body, const LawTable& table, const std::vector<std::size_t>& subset) {
  std::array<double, kappas> sum{};
  for (const std::size_t i : subset) {
    if (!knows(body.poses[i], 3)) continue;
    for (std::size_t k = 0; k < kappas; ++k)
      sum[k] += (table.at[k][i] - body.poses[i].load).tail<3>().squaredNorm() / (table.scale[i] * table.scale[i]);
  }
  const auto [lowest, highest] = std::minmax_element(sum.begin(), sum.end());
  if (!(*highest - *lowest > 1e-9)) return std::nullopt;  // no moments, or of poses where symmetry makes them 0
  const auto best = static_cast<std::size_t>(lowest - sum.begin());
  double shift = 0.0;
  if (best > 0 && best + 1 < kappas) {
    const double bend = sum[best - 1] - 2.0 * sum[best] + sum[best + 1];
    if (bend > 0.0) shift = std::clamp(0.5 * (sum[best - 1] - sum[best + 1]) / bend, -0.5, 0.5);
  }
  return (static_cast<double>(best) + shift) * kappa_step;
}

std::optional<Estimate> fitted_pillow(const BodyLoads& body, const LawTable& table) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < body.poses.size(); ++i) all.push_back(i);
  const std::optional<double> best = best_kappa(body, table, all);
  if (!best) return std::nullopt;
  Estimate estimate{.name = "kappa", .value = *best};
  estimate.at_bound = *best < 1e-6 || *best > (kappas - 1) * kappa_step - 1e-6;
  if (estimate.at_bound) return estimate;
  constexpr int draws = 400;  // the 2.5 % quantile then rests on ten refits
  std::mt19937 engine(20200301);
  std::vector<double> values;
  for (int draw = 0; draw < draws; ++draw) {
    std::vector<std::size_t> sample;
    for (std::size_t i = 0; i < all.size(); ++i) sample.push_back(engine() % all.size());
    if (const auto value = best_kappa(body, table, sample)) values.push_back(*value);
  }
  std::sort(values.begin(), values.end());
  estimate.interval = {values[values.size() / 40], values[values.size() - 1 - values.size() / 40]};
  return estimate;
}

/// What may be chosen for force or moment.
struct Choice {
  bool law = true;         ///< the prior; else the mean drag along the wind (of a moment: nothing)
  bool corrected = false;  ///< else the prior alone
  DirectionField::Kernel kernel{};
  double scatter = scatters[0];

  std::string text() const {
    if (!corrected) return law ? "the law alone" : "a constant";
    return fmt::format("{}, length {:g}", law ? "correction of the law" : "map without the law", kernel.length);
  }
};

/// Force (first = 0) or moment (3) of some of the poses.
struct Target {
  const BodyLoads& body;
  const LawTable& table;
  int first;
  std::vector<std::size_t> subset;
  double kappa;

  bool axial() const { return first == 3; }
  double mean_drag() const {
    double sum = 0.0;
    for (const std::size_t i : subset) sum += body.poses[i].load[0];
    return axial() ? 0.0 : sum / static_cast<double>(subset.size());
  }
  /// Wind frame.
  Vector3d prior(std::size_t pose, bool law) const {
    return law ? Vector3d(table.law(pose, kappa).segment<3>(first)) : Vector3d(mean_drag(), 0.0, 0.0);
  }
  std::vector<DirectionField::Observation> observations(bool law, double scatter) const {
    std::vector<DirectionField::Observation> list;
    for (const std::size_t i : subset) {
      const PoseLoad& pose = body.poses[i];
      const Vector3d before = prior(i, law);
      for (int c = 0; c < 3; ++c)
        if (const auto channel = static_cast<std::size_t>(first + c); pose.known[channel])
          list.push_back({pose.direction(), pose.to_wind.row(c).transpose(), pose.load[first + c] - before[c],
                          std::hypot(pose.u[first + c], scatter * table.scale[i]), table.orbit[i]});
    }
    return list;
  }
};

double rms(const std::vector<DirectionField::Observation>& observations) {
  double squares = 0.0;
  for (const auto& one : observations) squares += one.value * one.value;
  return observations.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(observations.size()));
}

/// Mean over the poses of the length of what is left, over the scale.
double score(const Target& target, const std::vector<DirectionField::Observation>& observations, const VectorXd& left) {
  double sum = 0.0;
  Eigen::Index at = 0;
  for (const std::size_t i : target.subset) {
    double squares = 0.0;
    for (int c = 0; c < 3; ++c)
      if (target.body.poses[i].known[static_cast<std::size_t>(target.first + c)]) squares += left[at] * left[at], ++at;
    sum += std::sqrt(squares) / target.table.scale[i];
  }
  return at == static_cast<Eigen::Index>(observations.size()) ? sum : std::numeric_limits<double>::infinity();
}

Choice best_choice(const Target& target) {
  Choice best;
  double lowest = std::numeric_limits<double>::infinity();
  for (const bool law : {true, false}) {
    for (const double scatter : scatters) {
      const auto observations = target.observations(law, scatter);
      if (observations.empty()) return best;
      if (law && scatter == scatters.front()) {
        VectorXd values(observations.size());
        for (std::size_t k = 0; k < observations.size(); ++k) values[static_cast<Eigen::Index>(k)] = observations[k].value;
        lowest = least_gain * score(target, observations, values);
        best.kernel.size = rms(observations);  // for how unsure it is
      }
      for (const double length : lengths)
        for (const double size : sizes) {
          const Choice choice{law, true, {length, size * rms(observations)}, scatter};
          if (!(choice.kernel.size > 0.0)) continue;
          const DirectionField field(observations, target.body.group, target.axial(), choice.kernel);
          if (const double found = score(target, observations, field.left_out_residuals()); found < lowest) lowest = found, best = choice;
        }
    }
  }
  return best;
}

/// Fitted to a subset of the poses, choices included.
struct SubsetFit {
  double kappa;
  Target force, moment;
  Choice force_choice, moment_choice;
  DirectionField force_field, moment_field;

  SubsetFit(const BodyLoads& body, const LawTable& table, const std::vector<std::size_t>& subset)
      : kappa(best_kappa(body, table, subset).value_or(dragcore::model_for(*body.surface).pillow.factor)),
        force{body, table, 0, subset, kappa},
        moment{body, table, 3, subset, kappa},
        force_choice(best_choice(force)),
        moment_choice(best_choice(moment)),
        force_field(force.observations(force_choice.law, force_choice.scatter), body.group, false, force_choice.kernel),
        moment_field(moment.observations(moment_choice.law, moment_choice.scatter), body.group, true, moment_choice.kernel) {}

  /// Wind frame, of a pose of the table.
  Channels at(std::size_t pose) const {
    const PoseLoad& one = force.body.poses[pose];
    Channels result;
    result << force.prior(pose, force_choice.law), moment.prior(pose, moment_choice.law);
    if (force_choice.corrected) result.head<3>() += one.to_wind * force_field.mean(one.direction());
    if (moment_choice.corrected) result.tail<3>() += one.to_wind * moment_field.mean(one.direction());
    return result;
  }
  /// Beyond the law, body frame.
  Channels beyond(const Channels& law, const Vector3d& direction) const {
    Channels result = Channels::Zero();
    if (force_choice.corrected) result.head<3>() = force_field.mean(direction);
    if (moment_choice.corrected) result.tail<3>() = moment_field.mean(direction);
    if (!force_choice.law) result.head<3>() += force.mean_drag() * direction - law.head<3>();
    if (!moment_choice.law) result.tail<3>() -= law.tail<3>();
    return result;
  }
};

std::vector<std::size_t> all_but(const LawTable& table, int orbit) {
  std::vector<std::size_t> rest;
  for (std::size_t i = 0; i < table.orbit.size(); ++i)
    if (table.orbit[i] != orbit) rest.push_back(i);
  return rest;
}

}  // namespace

BodyLoads body_loads(const Surface& surface, const std::vector<Matrix3d>& group,
                     const std::vector<std::pair<CaseRecord, Channels>>& records) {
  if (records.empty()) throw std::invalid_argument("calibrate: no usable case of this body; solve some first");
  BodyLoads body{.surface = &surface,
                 .group = group,
                 .reference_length = dragcore::properties(records.front().first.shape).reference_length,
                 .reynolds = records.front().first.reynolds};
  for (const auto& [record, u] : records) {
    const double force = 0.5 * record.density * record.speed * record.speed * surface.total_area, moment = force * surface.radius;
    PoseLoad pose{.name = record.name, .to_wind = record.pose.rotation(), .known = record.known};
    // From the body's centroid, the origin, to the centre of the surface; who does not know the force cannot.
    const Vector3d arm = pose.to_wind * surface.centre;
    pose.load << record.load.force() / force, (record.load.moment() - arm.cross(record.load.force())) / moment;
    pose.u << u.head<3>() / force, (u.tail<3>() + Vector3d::Constant(arm.norm() * u.head<3>().norm())) / moment;
    if (!record.knows_force() || !record.knows_moment()) pose.known[3] = pose.known[4] = pose.known[5] = false;
    body.poses.push_back(pose);
  }
  return body;
}

DirectionField::DirectionField(std::vector<Observation> observations, const std::vector<Matrix3d>& group, bool axial, const Kernel& kernel)
    : observations_(std::move(observations)), group_(&group), axial_(axial), kernel_(kernel) {
  double variance = 0.0;
  constexpr int directions = 64;  // within 2 % of the mean over all
  for (const Vector3d& d : spiral(directions)) variance += covariance(d, d).trace() / (3.0 * directions);
  norm_ = kernel_.size * kernel_.size / variance;
  const auto n = static_cast<Eigen::Index>(observations_.size());
  MatrixXd matrix(n, n);
  VectorXd values(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Observation& a = observations_[static_cast<std::size_t>(i)];
    values[i] = a.value;
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Observation& b = observations_[static_cast<std::size_t>(j)];
      matrix(i, j) = matrix(j, i) = a.axis.dot(covariance(a.direction, b.direction) * b.axis);
    }
    matrix(i, i) += a.u * a.u;
  }
  inverse_ = matrix.ldlt().solve(MatrixXd::Identity(n, n));
  weights_ = inverse_ * values;
}

Matrix3d DirectionField::covariance(const Vector3d& a, const Vector3d& b) const {
  Matrix3d sum = Matrix3d::Zero();
  for (const Matrix3d& g : *group_) {
    const double closeness = std::exp((a.dot(g * b) - 1.0) / (kernel_.length * kernel_.length));
    sum += (axial_ && g.determinant() < 0.0 ? -closeness : closeness) * g;
  }
  return norm_ * sum;
}

MatrixXd DirectionField::to_observations(const Vector3d& direction) const {
  MatrixXd cross(3, observations_.size());
  for (std::size_t k = 0; k < observations_.size(); ++k)
    cross.col(static_cast<Eigen::Index>(k)) = covariance(direction, observations_[k].direction) * observations_[k].axis;
  return cross;
}

Vector3d DirectionField::mean(const Vector3d& direction) const { return to_observations(direction) * weights_; }

double DirectionField::spread(const Vector3d& direction) const {
  const MatrixXd cross = to_observations(direction);
  return std::sqrt(std::max(0.0, (covariance(direction, direction) - cross * inverse_ * cross.transpose()).trace()));
}

VectorXd DirectionField::left_out_residuals() const {
  VectorXd residuals(weights_.size());
  std::map<int, std::vector<Eigen::Index>> poses;
  for (std::size_t k = 0; k < observations_.size(); ++k) poses[observations_[k].pose].push_back(static_cast<Eigen::Index>(k));
  for (const auto& [pose, members] : poses) {  // of a block of the inverse: what a fit without it leaves
    const MatrixXd block = inverse_(members, members);
    const VectorXd some = weights_(members), left = block.ldlt().solve(some);
    for (std::size_t k = 0; k < members.size(); ++k) residuals[members[k]] = left[static_cast<Eigen::Index>(k)];
  }
  return residuals;
}

PoseErrors pose_errors(const BodyLoads& body, const std::vector<PoseLoad>& poses, const dragcore::Model& model) {
  return errors_of(body, poses, scales(poses), predicted_by(body, poses, model));
}

ResidualFit fit_residual_map(const BodyLoads& body, const std::string& origin) {
  const auto whole = std::count_if(body.poses.begin(), body.poses.end(), [](const PoseLoad& pose) { return knows(pose, 0); });
  if (whole < 3)
    throw std::invalid_argument(
        fmt::format("calibrate: {} poses know their whole force, but at least 3 are needed; solve or measure more", whole));
  const Surface& surface = *body.surface;
  const LawTable table(body);
  const SubsetFit fit(body, table, all_but(table, -1));

  auto correction = std::make_shared<dragcore::Correction>();
  const dragcore::Model law = dragcore::model_for(surface);
  dragcore::Model model = with_pillow(law, fit.kappa);
  correction->map = dragcore::DirectionMap::zero(map_frequency, 1);
  for (int node = 0; node < correction->map.nodes(); ++node) {
    const Vector3d direction = correction->map.direction(node);
    const Channels beyond = fit.beyond(coefficients_of(body, model, direction), direction);
    correction->map.set(node, 0, beyond.head<3>(), beyond.tail<3>());
  }
  correction->body = surface.shape_moments;
  correction->viscous = body.reynolds < 1e4;
  correction->least_reynolds = correction->most_reynolds = body.reynolds * 2.0 * surface.radius / body.reference_length;
  correction->origin = origin;
  model.correction = correction;

  ResidualFit result{.model = model,
                     .pillow = fitted_pillow(body, table),
                     .errors = {},
                     .force_choice = fit.force_choice.text(),
                     .moment_choice = fit.moment_choice.text(),
                     .force = fit.force_field,
                     .force_length = fit.force_choice.kernel.length};
  for (std::size_t i = 0; i < body.poses.size(); ++i)
    result.mean_u += body.poses[i].u.head<3>().norm() / table.scale[i] / static_cast<double>(body.poses.size());

  const auto seen = [&](const dragcore::Model& of) { return errors_of(body, body.poses, table.scale, predicted_by(body, body.poses, of)); };
  dragcore::Model note;
  Predicted pillow_unseen(body.poses.size()), map_unseen(body.poses.size());
  for (std::size_t i = 0; i < body.poses.size(); ++i) {
    if (table.orbit[i] != static_cast<int>(i)) continue;  // with the first of its orbit
    const SubsetFit without(body, table, all_but(table, table.orbit[i]));
    for (std::size_t j = i; j < body.poses.size(); ++j)
      if (table.orbit[j] == table.orbit[i]) pillow_unseen[j] = table.law(j, without.kappa), map_unseen[j] = without.at(j);
  }
  result.errors = {{"note", seen(note), std::nullopt},
                   {"class law", seen(law), std::nullopt},
                   {"class law, pillow fitted", seen(with_pillow(law, fit.kappa)), errors_of(body, body.poses, table.scale, pillow_unseen)},
                   {"residual map", seen(model), errors_of(body, body.poses, table.scale, map_unseen)}};
  return result;
}

std::vector<Vector3d> next_directions(const std::vector<Vector3d>& known, const std::vector<Matrix3d>& group, double length, int count,
                                      const std::vector<Vector3d>& among) {
  const std::vector<Vector3d> mirrors = mirror_normals(group), candidates = among.empty() ? spiral(400) : among;
  const double near = std::sin(10.0 * std::numbers::pi / 180.0);
  std::vector<Vector3d> seen = known, found;
  for (int n = 0; n < count; ++n) {
    std::vector<DirectionField::Observation> observations;
    for (std::size_t k = 0; k < seen.size(); ++k)
      for (int axis = 0; axis < 3; ++axis) observations.push_back({seen[k], Vector3d::Unit(axis), 0.0, 0.05, static_cast<int>(k)});
    const DirectionField field(observations, group, false, {length, 1.0});
    Vector3d best = candidates.front();
    double largest = -1.0;
    for (const Vector3d& direction : candidates)
      if (const double spread = field.spread(direction); spread > largest * (1.0 + 1e-9)) largest = spread, best = direction;
    Vector3d upright = best;
    for (const Vector3d& normal : mirrors)
      if (const Vector3d in_plane = upright - normal * normal.dot(upright); std::abs(normal.dot(upright)) < near)
        upright = in_plane.normalized();
    // Not onto a pose that is known: many planes meet on an axis.
    const bool taken = std::any_of(seen.begin(), seen.end(), [&](const Vector3d& other) {
      return std::any_of(group.begin(), group.end(), [&](const Matrix3d& g) { return (g * other - upright).norm() < near; });
    });
    if (among.empty() && !taken) best = upright;
    seen.push_back(best), found.push_back(best);
  }
  return found;
}

dragcore::Pose pose_towards(const Vector3d& direction, const std::vector<Matrix3d>& group) {
  Vector3d sideways = Vector3d::UnitY() - direction * direction.y();
  if (sideways.norm() < 0.1) sideways = Vector3d::UnitZ() - direction * direction.z();
  // Of several mirror planes the one whose normal is nearest to y: least yaw and roll.
  double best = -1.0;
  for (const Vector3d& normal : mirror_normals(group))
    if (std::abs(normal.dot(direction)) < 1e-6 && std::abs(normal.y()) > best)
      best = std::abs(normal.y()), sideways = normal.y() < 0.0 ? Vector3d(-normal) : normal;
  Matrix3d to_wind;
  to_wind.row(0) = direction.normalized();
  to_wind.row(1) = sideways.normalized();
  to_wind.row(2) = direction.normalized().cross(sideways.normalized());
  constexpr double pi = std::numbers::pi;
  double incidence = std::asin(std::clamp(-to_wind(2, 0), -1.0, 1.0)), yaw = std::atan2(to_wind(1, 0), to_wind(0, 0)),
         roll = std::atan2(to_wind(2, 1), to_wind(2, 2));
  if (std::hypot(to_wind(0, 0), to_wind(1, 0)) < 1e-6)
    yaw = 0.0, roll = std::atan2(-to_wind(1, 2), to_wind(1, 1));  // only their sum is defined
  // The same by incidence beyond a right angle, where that leaves less to the other two.
  if (std::abs(yaw) + std::abs(roll) > pi) {
    incidence = (incidence < 0.0 ? -pi : pi) - incidence;
    yaw -= yaw > 0.0 ? pi : -pi, roll -= roll > 0.0 ? pi : -pi;
  }
  const auto rounded = [](double radians) { return std::round(1800.0 / pi * radians) * pi / 1800.0 + 0.0; };  // -0 is 0
  return {.incidence = rounded(incidence), .yaw = rounded(yaw), .roll = rounded(roll)};
}

}  // namespace compare
