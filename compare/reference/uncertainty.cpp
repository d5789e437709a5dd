#include "compare/reference/uncertainty.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "compare/reference/coefficients.hpp"

namespace compare {

using case_record::CaseRecord;

namespace {

using Eigen::ArrayXd;
using Eigen::VectorXd;

/// phi = phi_0 + sum_k alpha_k h^p_k, least squares.
struct Fit {
  double at_zero = 0.0;
  double order = 0.0;      ///< of the free-order fit
  double error = 0.0;      ///< |sum alpha_k h_1^p_k| on the finest mesh
  double residual = 0.0;   ///< phi_1 - fit at h_1
  double deviation = 0.0;  ///< standard deviation of the fit
  std::string name;
};

/// @param parameters  free numbers of the fit, including an order if that was sought: n minus this are the degrees of freedom
Fit fit_orders(const VectorXd& h, const VectorXd& phi, const VectorXd& weights, const std::vector<double>& orders, int parameters) {
  Eigen::MatrixXd terms(h.size(), static_cast<Eigen::Index>(orders.size()) + 1);
  terms.col(0).setOnes();
  for (std::size_t k = 0; k < orders.size(); ++k) terms.col(static_cast<Eigen::Index>(k) + 1) = h.array().pow(orders[k]);
  const VectorXd root = weights.cwiseSqrt();
  const VectorXd solution = (root.asDiagonal() * terms).colPivHouseholderQr().solve(root.asDiagonal() * phi);
  const VectorXd residual = phi - terms * solution;
  Fit fit;
  fit.at_zero = solution[0];
  fit.error = std::abs(terms.row(0).tail(terms.cols() - 1).dot(solution.tail(terms.cols() - 1)));
  fit.residual = residual[0];
  const double freedom = static_cast<double>(h.size()) - parameters;
  // Weights sum to one: n times the weighted mean square is a sum of squares.
  fit.deviation = freedom > 0 ? std::sqrt(static_cast<double>(h.size()) * weights.dot(residual.cwiseAbs2()) / freedom) : 0.0;
  return fit;
}

/// Of the line phi = phi_0 + alpha h^p, the regression of phi on h^p: what is left of phi, without solving a system. Hundreds of orders are
/// tried for every channel of every family. @param weights  sum 1
double sum_of_squares(const ArrayXd& log_h, const ArrayXd& phi, const ArrayXd& weights, double p) {
  const ArrayXd x = (p * log_h).exp();
  const ArrayXd dx = x - (weights * x).sum(), dphi = phi - (weights * phi).sum();
  const double slope = (weights * dx * dphi).sum() / (weights * dx * dx).sum();
  return (weights * (dphi - slope * dx).square()).sum();
}

/// The order for which the fit is best; nothing when that is at an end of the range: no convergence seen.
std::optional<Fit> fit_free_order(const VectorXd& h, const VectorXd& phi, const VectorXd& weights) {
  constexpr double lowest = 0.05, highest = 8.0, step = 0.05;
  const ArrayXd log_h = h.array().log();
  const auto at = [&](double p) { return sum_of_squares(log_h, phi, weights, p); };
  // The sum of squares may have several minima: a scan finds the lowest, Brent's method its place.
  double best = lowest, best_sum = at(lowest);
  for (double p = lowest + step; p <= highest; p += step)
    if (const double sum = at(p); sum < best_sum) best_sum = sum, best = p;
  if (best <= lowest || best > highest - step) return std::nullopt;
  const double order = boost::math::tools::brent_find_minima(at, best - step, best + step, 40).first;
  Fit fit = fit_orders(h, phi, weights, {order}, 3);
  fit.order = order;
  return fit;
}

Fit better(const Fit& a, const Fit& b) { return b.deviation < a.deviation ? b : a; }

/// Cell size and value of each mesh, finest first.
std::vector<std::pair<double, double>> finest_first(const std::vector<double>& cells, const std::vector<double>& values) {
  const std::size_t n = cells.size();
  if (n != values.size())
    throw std::invalid_argument(fmt::format("{} meshes but {} values; one value per mesh is needed", n, values.size()));
  std::vector<std::pair<double, double>> levels;
  for (std::size_t i = 0; i < n; ++i) {
    if (!(cells[i] > 0.0) || !std::isfinite(values[i]))
      throw std::invalid_argument(
          fmt::format("mesh of {} cells with value {}; positive and finite numbers are needed", cells[i], values[i]));
    levels.emplace_back(std::cbrt(1.0 / cells[i]), values[i]);
  }
  std::sort(levels.begin(), levels.end());
  for (std::size_t i = 1; i < n; ++i)
    if (levels[i].first < 1.05 * levels[i - 1].first)
      throw std::invalid_argument(
          fmt::format("two meshes have {:.0f} and {:.0f} cells, a ratio of cell sizes of {:.3f}; at least 1.05 is needed: the "
                      "same mesh twice proves nothing",
                      std::pow(levels[i].first, -3), std::pow(levels[i - 1].first, -3), levels[i].first / levels[i - 1].first));
  return levels;
}

CaseRecord::Channels load_of(const CaseRecord& record) {
  CaseRecord::Channels load;
  load << record.load.force(), record.load.moment();
  return load;
}

}  // namespace

GridStudy grid_study(const std::vector<double>& cells, const std::vector<double>& values, double earned) {
  const std::size_t n = cells.size();
  if (n < 3 && n == values.size())
    throw std::invalid_argument(fmt::format("{} meshes; the discretisation uncertainty needs at least 3", n));
  const auto levels = finest_first(cells, values);

  const auto count = static_cast<Eigen::Index>(n);
  VectorXd h(count), phi(count);
  for (Eigen::Index i = 0; i < count; ++i)
    h[i] = levels[static_cast<std::size_t>(i)].first / levels[0].first, phi[i] = levels[static_cast<std::size_t>(i)].second;
  const VectorXd equal = VectorXd::Constant(count, 1.0 / static_cast<double>(n));
  const VectorXd fine_first = h.cwiseInverse() / h.cwiseInverse().sum();
  const double range = phi.maxCoeff() - phi.minCoeff();
  GridStudy study;
  if (range == 0.0) {
    study.extrapolated = phi[0];
    study.branch = "no difference between meshes";
    return study;
  }

  const double finest = phi[0];
  phi = (phi.array() - finest) / range;  // well-scaled, whatever the unit
  std::optional<Fit> free = fit_free_order(h, phi, equal);
  if (const auto weighted = fit_free_order(h, phi, fine_first)) free = free ? better(*free, *weighted) : weighted;
  const double order = free ? free->order : 0.0;
  const bool in_range = free && order >= 0.5 && order <= 2.0;
  const bool blind = n == 3;
  if (blind && !in_range && !(free && order > 2.0)) {
    // Three meshes cannot tell scatter from a trend of unknown order: three times their range, a 95 % figure. A fall steeper than the
    // scheme's order is taken for one of that order below, which leaves more to go.
    study.uncertainty = 3.0 * range / 2.0;
    study.extrapolated = finest;
    study.branch = free ? fmt::format("data range: order {:.2f} of three meshes is outside [0.5, 2]", order)
                        : std::string("data range: three meshes without monotonic convergence");
    return study;
  }

  Fit fit;
  if (in_range) {
    fit = *free;
    fit.name = fmt::format("observed order {:.2f}", order);
    study.order = order;
  } else {
    const auto fixed = [&](const std::vector<double>& orders, const char* name) {
      const int parameters = static_cast<int>(orders.size()) + 1;
      Fit best = better(fit_orders(h, phi, equal, orders, parameters), fit_orders(h, phi, fine_first, orders, parameters));
      best.name = name;
      return best;
    };
    fit = better(fixed({1.0}, "first-order fit"), fixed({2.0}, "second-order fit"));
    if (!free || order < 0.5) fit = better(fit, fixed({1.0, 2.0}, "first- and second-order fit"));
    fit.name += free ? fmt::format(" (observed order {:.2f})", order) : std::string(" (no observed order)");
  }

  const double spread = 1.0 / (static_cast<double>(n) - 1.0);  // range / (n - 1), what the standard deviation is held against
  const double lowest_trusted = blind ? 1.0 : 0.5;             // three meshes show no scatter: a slow fall of theirs may be one
  const bool trusted = free && order >= lowest_trusted && order <= 2.1 && fit.deviation < spread;
  const double safety = trusted ? earned : 3.0;
  // Where scatter hides the trend an extrapolation may go anywhere: it counts up to what three meshes without a trend get.
  const double wide = fit.deviation < spread
                          ? safety * fit.error + fit.deviation + std::abs(fit.residual)
                          : std::min(3.0, 3.0 * fit.deviation / spread * (fit.error + fit.deviation + std::abs(fit.residual)));
  study.safety = safety;
  study.uncertainty = range * wide / 2.0;  // the procedure's figure covers 95 %
  study.extrapolated = finest + range * fit.at_zero;
  study.branch =
      fit.deviation < spread ? fmt::format("{}, safety factor {}", fit.name, safety) : fit.name + ", scatter above the data spread";
  return study;
}

GridStudy two_grid_study(const std::vector<double>& cells, const std::vector<double>& values) {
  constexpr double order = 2.0, safety = 3.0;
  if (cells.size() != 2 && cells.size() == values.size())
    throw std::invalid_argument(fmt::format("{} meshes; an estimate with an assumed order takes two", cells.size()));
  const auto levels = finest_first(cells, values);
  const double correction = (levels[0].second - levels[1].second) / (std::pow(levels[1].first / levels[0].first, order) - 1.0);
  return {.uncertainty = safety * std::abs(correction) / 2.0,
          .extrapolated = levels[0].second + correction,
          .branch = fmt::format("two levels, order {:g} assumed, safety factor {:g}", order, safety)};
}

GridStudy mesh_study(const std::vector<double>& cells, const std::vector<double>& values, const std::string& flow_model) {
  return cells.size() == 2 ? two_grid_study(cells, values) : grid_study(cells, values, flow_model.starts_with("laminar") ? 1.25 : 3.0);
}

double propagated(const CaseRecord& record, const LoadUncertainty::Channels& u,
                  const std::function<std::optional<double>(const Eigen::Vector3d&, const Eigen::Vector3d&)>& quantity) {
  using Eigen::Vector3d;
  const Vector3d force = record.load.force(), moment = record.load.moment();
  double sum = 0.0;
  for (Eigen::Index k = 0; k < 6; ++k) {
    // A step small against the force leaves the central difference exact to 1e-8, far below any uncertainty.
    const double step = 1e-4 * coefficient_scales(record)[k];
    Vector3d df = Vector3d::Zero(), dm = Vector3d::Zero();
    (k < 3 ? df[k] : dm[k - 3]) = step;
    const auto above = quantity(force + df, moment + dm), below = quantity(force - df, moment - dm);
    if (above && below) sum += std::pow((*above - *below) / (2.0 * step) * u[k], 2);
  }
  return std::sqrt(sum);
}

CaseName split_name(const std::string& case_name, const std::string& mesh_level) {
  const std::string part = "_" + mesh_level;
  if (mesh_level.empty()) return {case_name, ""};
  for (std::size_t at = case_name.find(part); at != std::string::npos; at = case_name.find(part, at + 1)) {
    const std::string rest = case_name.substr(at + part.size());
    if (rest.empty()) return {case_name.substr(0, at), ""};
    if (rest.front() == '_') return {case_name.substr(0, at), rest.substr(1)};
  }
  return {case_name, ""};
}

std::string family_name(const std::string& case_name, const std::string& mesh_level) {
  const CaseName name = split_name(case_name, mesh_level);
  return name.variant.empty() ? name.stem : name.stem + "_" + name.variant;
}

std::vector<const CaseRecord*> CaseFamily::usable_levels() const {
  std::vector<const CaseRecord*> usable;
  for (const CaseRecord* level : levels)
    if (case_record::is_usable(level->status)) usable.push_back(level);
  return usable;
}

std::optional<CaseRecord::Channels> discretisation_at(const CaseFamily& family, const CaseRecord& level) {
  if (!family.uncertainty.discretisation_assessed) return std::nullopt;
  const CaseRecord::Channels away = load_of(level) - load_of(*family.record);
  return (away.cwiseAbs2() + family.uncertainty.discretisation.cwiseAbs2()).cwiseSqrt();
}

namespace {

using Channels = CaseRecord::Channels;

/// What a carried uncertainty is relative to, as coefficients: the channel, but no less than a share of the force (of the moment, of a body
/// that spins in still air), so that a channel near zero is neither exact nor infinitely uncertain. Wakes lean to a side by up to a third
/// of what they do along the wind, and the arm of the force is about a tenth of the body.
Channels carrying_scale(const CaseRecord& record) {
  constexpr double share_of_force = 0.3, share_of_moment = 0.1;
  Channels c = coefficients(record).values;
  const double size = std::max(c.head<3>().norm(), c.tail<3>().norm());
  c.head<3>() = c.head<3>().cwiseAbs().cwiseMax(share_of_force * size);
  c.tail<3>() = c.tail<3>().cwiseAbs().cwiseMax(share_of_moment * size);
  return c;
}

/// u_disc from the usable levels, every channel with the branch that found it.
void study_levels(CaseFamily& family) {
  LoadUncertainty& u = family.uncertainty;
  u.branches.clear();
  try {
    for (Eigen::Index channel = 0; channel < 6; ++channel) {
      std::vector<double> cells, values;
      for (const CaseRecord* level : family.usable_levels()) cells.push_back(level->cells), values.push_back(load_of(*level)[channel]);
      const GridStudy found = mesh_study(cells, values, family.record->flow_model);
      u.discretisation[channel] = found.uncertainty;
      u.branches.push_back(found.branch);
    }
    u.discretisation_assessed = true;
  } catch (const std::invalid_argument& refusal) {
    u = {};
    u.branches = {std::string("refused: ") + refusal.what()};  // stays "not assessed", and the tables say why
  }
}

/// What a representative family says about the mesh error of a case like it, on a mesh of the same level.
struct Carried {
  const CaseFamily* from = nullptr;
  double force = 0.0, moment = 0.0;  ///< u relative to carrying_scale(): largest of the three channels
};

std::optional<Carried> carried_from(const CaseFamily& family, const std::string& level) {
  for (const CaseRecord* at : family.usable_levels()) {
    if (at->mesh_level != level) continue;
    const Channels relative =
        discretisation_at(family, *at)->cwiseQuotient(coefficient_scales(*at)).cwiseQuotient(carrying_scale(*family.record));
    // A force off by some per cent has a moment off by no less; where symmetry makes the moment zero it would not show. In still air the
    // force is nothing.
    const double force = relative.head<3>().maxCoeff(), moment = relative.tail<3>().maxCoeff();
    return Carried{&family, force, at->still_air ? moment : std::max(force, moment)};
  }
  return std::nullopt;
}

/// Where the wind comes from, or the axis of a spin in still air: body frame, unit length.
Eigen::Vector3d exposure(const CaseRecord& record) {
  return record.pose.rotation().transpose() * (record.still_air ? record.angular_velocity.normalized() : Eigen::Vector3d::UnitX());
}

std::optional<Carried> nearest_representative(const CaseFamily& family, const std::vector<const CaseFamily*>& representatives) {
  const CaseRecord& record = *family.record;
  std::optional<Carried> best;
  double nearest = -1e9;  // cosine of the angle between exposures, 3 more for the same body
  for (const CaseFamily* candidate : representatives) {
    const CaseRecord& other = *candidate->record;
    if (dragcore::kind(other.shape) != dragcore::kind(record.shape) || other.flow_model != record.flow_model ||
        other.still_air != record.still_air || other.spins() != record.spins())
      continue;
    const auto carried = carried_from(*candidate, record.mesh_level);
    if (!carried) continue;
    constexpr double same = 1e-6;  // a pose half way between two takes the worse
    // A decade of the Reynolds number counts as much as a turn by 26 degrees: wakes change with both.
    const double decades = std::abs(std::log10(other.reynolds / record.reynolds));
    const double closeness =
        exposure(record).dot(exposure(other)) - 0.1 * decades + (other.surface_checksum == record.surface_checksum ? 3.0 : 0.0);
    if (best && (closeness < nearest - same || (closeness < nearest + same && carried->force <= best->force))) continue;
    best = carried;
    nearest = closeness;
  }
  return best;
}

/// Fewer than three levels: the larger of what two levels show and what a representative says.
void assess_by_others(CaseFamily& family, const std::vector<const CaseFamily*>& representatives) {
  LoadUncertainty& u = family.uncertainty;
  const auto carried = nearest_representative(family, representatives);
  if (!carried) {
    if (u.branches.empty()) u.branches = {"not assessed: one level, and no family of three levels to carry from"};
    return;
  }
  const std::string own = u.branches.empty() ? "" : u.branches.front();  // of two levels, or why they were refused
  const Channels scale = carrying_scale(*family.record);
  std::vector<std::string> branches;
  for (Eigen::Index channel = 0; channel < 6; ++channel) {
    const double ratio = channel < 3 ? carried->force : carried->moment;
    const double value = ratio * scale[channel] * coefficient_scales(*family.record)[channel];
    const std::string text = fmt::format("carried from {} {}: {:.2g} %", carried->from->name, family.record->mesh_level, 100.0 * ratio);
    if (u.discretisation_assessed && u.discretisation[channel] >= value) {
      branches.push_back(own + ", more than " + text);
      continue;
    }
    u.discretisation[channel] = value;
    branches.push_back(own.empty() ? text : own + (u.discretisation_assessed ? ", less than " : "; ") + text);
  }
  u.branches = std::move(branches);
  u.discretisation_assessed = true;
}

}  // namespace

std::vector<CaseFamily> case_families(const std::vector<CaseRecord>& records) {
  std::map<std::string, CaseFamily> families;
  for (const CaseRecord& record : records) families[family_name(record.name, record.mesh_level)].levels.push_back(&record);
  std::vector<CaseFamily> list;
  for (auto& [name, family] : families) {
    family.name = name;
    std::stable_sort(family.levels.begin(), family.levels.end(), [](const auto* a, const auto* b) { return a->cells < b->cells; });
    const auto usable = family.usable_levels();
    family.record = usable.empty() ? family.levels.back() : usable.back();
    if (usable.size() >= 2) study_levels(family);
    if (family.record->is_experiment()) {
      family.uncertainty.discretisation_assessed = true;
      family.uncertainty.branches = {"measured: there is no mesh"};
    }
    list.push_back(std::move(family));
  }

  std::vector<const CaseFamily*> representatives;
  for (const CaseFamily& family : list)
    if (family.uncertainty.discretisation_assessed && family.usable_levels().size() >= 3 &&
        split_name(family.record->name, family.record->mesh_level).variant.empty())
      representatives.push_back(&family);
  for (CaseFamily& family : list) {
    if (!case_record::is_usable(family.record->status)) continue;
    LoadUncertainty& u = family.uncertainty;
    const bool of_a_mesh = !family.record->is_experiment();
    if (of_a_mesh && (family.usable_levels().size() < 3 || !u.discretisation_assessed)) assess_by_others(family, representatives);
    u.numerical = (u.discretisation.cwiseAbs2() + family.record->own_variance()).cwiseSqrt();
    u.total = u.numerical;
  }
  return list;
}

}  // namespace compare
