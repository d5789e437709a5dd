#include "compare/uncertainty.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>

namespace compare {
namespace {

using Eigen::VectorXd;

/// phi = phi_0 + sum_k alpha_k h^p_k, least squares.
struct Fit {
  double at_zero = 0.0;
  double order = 0.0;           ///< of the free-order fit
  double error = 0.0;           ///< |sum alpha_k h_1^p_k| on the finest mesh
  double residual = 0.0;        ///< phi_1 - fit at h_1
  double sum_of_squares = 0.0;  ///< weighted
  double deviation = 0.0;       ///< standard deviation of the fit
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
  fit.sum_of_squares = weights.dot(residual.cwiseAbs2());
  const double freedom = static_cast<double>(h.size()) - parameters;
  // Weights sum to one: n times the weighted mean square is a sum of squares.
  fit.deviation = freedom > 0 ? std::sqrt(static_cast<double>(h.size()) * fit.sum_of_squares / freedom) : 0.0;
  return fit;
}

/// The order for which the fit is best; nothing when that is at an end of the range: no convergence seen.
std::optional<Fit> fit_free_order(const VectorXd& h, const VectorXd& phi, const VectorXd& weights) {
  constexpr double lowest = 0.05, highest = 8.0, step = 0.05;
  const auto at = [&](double p) { return fit_orders(h, phi, weights, {p}, 3); };
  // The sum of squares may have several minima: a scan finds the lowest, Brent's method its place.
  double best = lowest, best_sum = at(lowest).sum_of_squares;
  for (double p = lowest + step; p <= highest; p += step)
    if (const double sum = at(p).sum_of_squares; sum < best_sum) best_sum = sum, best = p;
  if (best <= lowest || best > highest - step) return std::nullopt;
  const double order =
      boost::math::tools::brent_find_minima([&](double p) { return at(p).sum_of_squares; }, best - step, best + step, 40).first;
  Fit fit = at(order);
  fit.order = order;
  return fit;
}

Fit better(const Fit& a, const Fit& b) { return b.deviation < a.deviation ? b : a; }

}  // namespace

GridStudy grid_study(const std::vector<double>& cells, const std::vector<double>& values) {
  const std::size_t n = cells.size();
  if (n != values.size())
    throw std::invalid_argument(fmt::format("{} meshes but {} values; one value per mesh is needed", n, values.size()));
  if (n < 3) throw std::invalid_argument(fmt::format("{} meshes; the discretisation uncertainty needs at least 3", n));
  std::vector<std::pair<double, double>> levels;  // cell size and value, finest first
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
  if (blind && !in_range) {
    // Three meshes cannot tell scatter from a trend of unknown order: three times their range, a 95 % figure.
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
  const bool trusted = !blind && (in_range || (free && order <= 2.1 && order >= 0.5)) && fit.deviation < spread;
  const double safety = trusted ? 1.25 : 3.0;
  const double wide = fit.deviation < spread ? safety * fit.error + fit.deviation + std::abs(fit.residual)
                                             : 3.0 * fit.deviation / spread * (fit.error + fit.deviation + std::abs(fit.residual));
  study.uncertainty = range * wide / 2.0;  // the procedure's figure covers 95 %
  study.extrapolated = finest + range * fit.at_zero;
  study.branch =
      fit.deviation < spread ? fmt::format("{}, safety factor {}", fit.name, safety) : fit.name + ", scatter above the data spread";
  return study;
}

std::string family_name(const std::string& case_name, const std::string& mesh_level) {
  const std::string part = "_" + mesh_level;
  const std::size_t at = mesh_level.empty() ? std::string::npos : case_name.rfind(part);
  if (at == std::string::npos) return case_name;
  const std::string rest = case_name.substr(at + part.size());  // "_variant", or nothing
  return rest.empty() || rest.front() == '_' ? case_name.substr(0, at) + rest : case_name;
}

std::vector<CaseFamily> case_families(const std::vector<case_record::CaseRecord>& records) {
  std::map<std::string, CaseFamily> families;
  for (const auto& record : records) families[family_name(record.name, record.mesh_level)].levels.push_back(&record);
  std::vector<CaseFamily> list;
  for (auto& [name, family] : families) {
    std::stable_sort(family.levels.begin(), family.levels.end(), [](const auto* a, const auto* b) { return a->cells < b->cells; });
    std::vector<const case_record::CaseRecord*> usable;
    for (const auto* level : family.levels)
      if (case_record::is_usable(level->status)) usable.push_back(level);
    family.record = usable.empty() ? family.levels.back() : usable.back();

    LoadUncertainty& u = family.uncertainty;
    if (usable.size() >= 3) try {
        std::vector<double> cells;
        for (const auto* level : usable) cells.push_back(level->cells);
        for (Eigen::Index channel = 0; channel < 6; ++channel) {
          std::vector<double> values;
          for (const auto* level : usable) values.push_back(channel < 3 ? level->load.force()[channel] : level->load.moment()[channel - 3]);
          const GridStudy study = grid_study(cells, values);
          u.discretisation[channel] = study.uncertainty;
          u.branches.push_back(study.branch);
        }
        u.discretisation_assessed = true;
      } catch (const std::invalid_argument& refusal) {
        u = {};
        u.branches = {std::string("refused: ") + refusal.what()};  // stays "not assessed", and the tables say why
      }
    if (!usable.empty())
      u.total = (u.discretisation.array().square() + family.record->u_iteration.array().square() +
                 family.record->u_statistical.array().square() + family.record->u_null.array().square())
                    .sqrt();
    list.push_back(std::move(family));
  }
  return list;
}

}  // namespace compare
