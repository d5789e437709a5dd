#include "compare/calibration/calibration.hpp"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/interpolators/barycentric_rational.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>

#include "compare/calibration/prediction.hpp"
#include "compare/reference/case_of_record.hpp"
#include "compare/reference/coefficients.hpp"

namespace compare {

namespace {

using case_record::CaseRecord;
using dragcore::PillowForm;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Parameter {
  std::string name;
  double low, high;
  double null;                    ///< value of the null model
  double note;                    ///< value of the note
  std::optional<double> start{};  ///< of the search; else half a unit above `low`
};

/// A fit: residuals of the cases as functions of the parameters, cheap to evaluate.
struct Problem {
  std::vector<Parameter> parameters;
  std::vector<const CaseRecord*> cases;  ///< of every residual
  std::function<double(std::size_t, const double*)> residual;
  std::function<void(const std::vector<std::size_t>&, const double*, double*)> residuals{};  ///< of many at once, where that is cheaper
  std::size_t channels = 1;                                                                  ///< residuals that one case has, in a row
  int bootstrap_draws = 400;  ///< the 2.5 % quantile then rests on ten refits

  VectorXd vector(double Parameter::*member) const {
    VectorXd values(parameters.size());
    for (std::size_t i = 0; i < parameters.size(); ++i) values[static_cast<Eigen::Index>(i)] = parameters[i].*member;
    return values;
  }
};

struct Residuals {
  const Problem* problem;
  const std::vector<std::size_t>* subset;
  bool operator()(double const* const* parameters, double* out) const {
    if (problem->residuals)
      problem->residuals(*subset, parameters[0], out);
    else
      for (std::size_t i = 0; i < subset->size(); ++i) out[i] = problem->residual((*subset)[i], parameters[0]);
    return true;
  }
};

/// Bounded least squares over a subset of the cases; a case may be in it more than once.
VectorXd solve(const Problem& problem, const std::vector<std::size_t>& subset) {
  VectorXd values = problem.vector(&Parameter::null);
  auto* cost = new ceres::DynamicNumericDiffCostFunction<Residuals, ceres::CENTRAL>(new Residuals{&problem, &subset});
  cost->AddParameterBlock(static_cast<int>(values.size()));
  cost->SetNumResiduals(static_cast<int>(subset.size()));
  ceres::Problem system;
  system.AddResidualBlock(cost, nullptr, values.data());
  for (std::size_t i = 0; i < problem.parameters.size(); ++i) {
    const Parameter& parameter = problem.parameters[i];
    // A start on the bound would have no room for the difference quotient.
    values[static_cast<Eigen::Index>(i)] =
        parameter.start.value_or(parameter.low + 0.5 * (std::min(parameter.high, parameter.low + 1.0) - parameter.low));
    system.SetParameterLowerBound(values.data(), static_cast<int>(i), parameter.low);
    system.SetParameterUpperBound(values.data(), static_cast<int>(i), parameter.high);
  }
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = options.parameter_tolerance = options.gradient_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &system, &summary);
  if (!summary.IsSolutionUsable()) throw std::runtime_error("calibrate: the least-squares solver failed: " + summary.message);
  return values;
}

std::vector<std::size_t> all_of(const Problem& problem) {
  std::vector<std::size_t> subset(problem.cases.size());
  std::iota(subset.begin(), subset.end(), 0);
  return subset;
}

std::string shape_of(const CaseRecord& record) { return dragcore::kind(record.shape); }

/// Shape and orientation: what is left out together.
std::string pose_of(const CaseRecord& record) {
  std::string text = shape_of(record);
  for (const double angle : {record.pose.incidence, record.pose.yaw, record.pose.roll}) text += " " + std::to_string(angle);
  return text;
}

/// Residual of every case when the fit has not seen any case of its group.
std::vector<double> left_out_residuals(const Problem& problem, std::string (*group_of)(const CaseRecord&)) {
  std::vector<double> residuals(problem.cases.size());
  std::set<std::string> groups;
  for (const CaseRecord* record : problem.cases) groups.insert(group_of(*record));
  if (groups.size() == 1) return std::vector<double>(problem.cases.size(), std::nan(""));  // nothing would be left to fit to
  for (const std::string& group : groups) {
    std::vector<std::size_t> rest, out;
    for (std::size_t i = 0; i < problem.cases.size(); ++i) (group_of(*problem.cases[i]) == group ? out : rest).push_back(i);
    if (rest.size() <= problem.parameters.size())
      throw std::invalid_argument("calibrate: only " + std::to_string(rest.size()) + " cases are left without " + group +
                                  "; solve more shapes or orientations first");
    const VectorXd values = solve(problem, rest);
    for (const std::size_t i : out) residuals[i] = problem.residual(i, values.data());
  }
  return residuals;
}

std::vector<double> residuals_at(const Problem& problem, const VectorXd& values) {
  std::vector<double> residuals;
  for (std::size_t i = 0; i < problem.cases.size(); ++i) residuals.push_back(problem.residual(i, values.data()));
  return residuals;
}

/// Percentile bootstrap over cases: 95 % of the refits to resampled cases.
std::vector<std::pair<double, double>> bootstrap(const Problem& problem) {
  const int draws = problem.bootstrap_draws;
  const std::size_t count = problem.cases.size() / problem.channels;
  std::mt19937 engine(20200301);
  MatrixXd values(draws, static_cast<Eigen::Index>(problem.parameters.size()));
  for (int draw = 0; draw < draws; ++draw) {
    std::vector<std::size_t> sample;
    for (std::size_t i = 0; i < count; ++i) {  // whole cases: channels of one are not independent
      const std::size_t drawn = engine() % count;
      for (std::size_t channel = 0; channel < problem.channels; ++channel) sample.push_back(drawn * problem.channels + channel);
    }
    values.row(draw) = solve(problem, sample).transpose();
  }
  std::vector<std::pair<double, double>> intervals;
  for (Eigen::Index k = 0; k < values.cols(); ++k) {
    std::vector<double> column(values.col(k).begin(), values.col(k).end());
    std::sort(column.begin(), column.end());
    intervals.emplace_back(column[draws / 40], column[draws - 1 - draws / 40]);
  }
  return intervals;
}

Fit fit(const Problem& problem, const std::string& name, const std::string& target) {
  Fit result{.name = name, .target = target};
  for (std::size_t i = 0; i < problem.cases.size(); i += problem.channels) result.cases.push_back(problem.cases[i]->name);
  const VectorXd best = solve(problem, all_of(problem));
  const auto intervals = bootstrap(problem);
  for (std::size_t i = 0; i < problem.parameters.size(); ++i) {
    const Parameter& p = problem.parameters[i];
    const double value = best[static_cast<Eigen::Index>(i)];
    const bool at_bound = std::min(value - p.low, p.high - value) < 1e-6 * (p.high - p.low);
    result.estimates.push_back({p.name, value, at_bound ? std::nullopt : std::optional(intervals[i]), at_bound});
  }

  // Correlation and conditioning from the slopes of the residuals.
  const auto n = static_cast<Eigen::Index>(problem.cases.size()), m = best.size();
  MatrixXd slope(n, m);
  for (Eigen::Index k = 0; k < m; ++k) {
    constexpr double step = 1e-5;
    VectorXd up = best, down = best;
    up[k] += step;
    down[k] -= step;
    for (Eigen::Index i = 0; i < n; ++i)
      slope(i, k) =
          (problem.residual(static_cast<std::size_t>(i), up.data()) - problem.residual(static_cast<std::size_t>(i), down.data())) /
          (2 * step);
    if (slope.col(k).norm() > 0.0) slope.col(k).normalize();
  }
  const MatrixXd normal = slope.transpose() * slope;
  const VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<MatrixXd>(normal).eigenvalues();
  result.condition_number = eigenvalues.maxCoeff() / std::max(eigenvalues.minCoeff(), 1e-300);
  const MatrixXd covariance = normal.completeOrthogonalDecomposition().pseudoInverse();
  for (Eigen::Index i = 0; i < m; ++i) {
    result.correlation.emplace_back();
    for (Eigen::Index j = 0; j < m; ++j)
      result.correlation.back().push_back(covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j)));
  }

  const auto before = residuals_at(problem, problem.vector(&Parameter::null)),
             note = residuals_at(problem, problem.vector(&Parameter::note));
  const auto after = residuals_at(problem, best);
  const auto no_pose = left_out_residuals(problem, pose_of), no_shape = left_out_residuals(problem, shape_of);
  std::vector<std::string> groups{"all"};
  for (const CaseRecord* record : problem.cases)
    if (std::find(groups.begin(), groups.end(), shape_of(*record)) == groups.end()) groups.push_back(shape_of(*record));
  for (const std::string& group : groups) {
    FitErrors errors{.group = group};
    const auto rms = [&](const std::vector<double>& residuals) {
      double sum = 0.0;
      errors.n = 0;
      for (std::size_t i = 0; i < residuals.size(); ++i)
        if (group == "all" || shape_of(*problem.cases[i]) == group) sum += residuals[i] * residuals[i], ++errors.n;
      errors.n /= static_cast<int>(problem.channels);
      return std::sqrt(sum / errors.n);
    };
    errors.before = rms(before);
    errors.note = rms(note);
    errors.in_sample = rms(after);
    errors.left_out_pose = rms(no_pose);
    errors.left_out_shape = rms(no_shape);
    result.errors.push_back(errors);
  }
  return result;
}

/// C_D = k_w C_w + k_b C_b: linear, so that the two parts are evaluated once.
Fit fit_drag(const std::vector<const CaseRecord*>& cases) {
  std::vector<double> windward, suction, reference;
  for (const CaseRecord* record : cases) {
    const dragcore::WrenchByTerm parts = predict(*record, dragcore::Model{.law = dragcore::scaled_law(1.0, 1.0)});
    const double scale = coefficient_scales(*record)[0];
    windward.push_back(parts[dragcore::Term::windward_pressure].force.x() / scale);
    suction.push_back(parts[dragcore::Term::leeward_suction].force.x() / scale);
    reference.push_back(record->load.force().x() / scale);
  }
  const Problem problem{.parameters = {{"scale", 0.0, 3.0, 1.0, 1.0}, {"base_suction", 0.0, 3.0, 0.0, 0.0}},
                        .cases = cases,
                        .residual = [=](std::size_t i, const double* k) { return k[0] * windward[i] + k[1] * suction[i] - reference[i]; }};
  Fit result = fit(problem, "C_D: scale and base suction", "C_D");
  result.model.law = dragcore::scaled_law(result.estimates[0].value, result.estimates[1].value);
  return result;
}

Fit fit_pillow(const std::vector<const CaseRecord*>& cases, const NamedModel& law, PillowForm form) {
  // The arm is a smooth function of the factor alone: tabulated per case, interpolated by the fit.
  const double largest = form == PillowForm::tilt ? 1.5 : 1.0;
  constexpr int points = 13;
  std::vector<boost::math::barycentric_rational<double>> curves;
  std::vector<double> reference;
  std::vector<const CaseRecord*> used;
  for (const CaseRecord* record : cases) {
    if (!record->knows_force() || !record->knows_moment()) continue;
    const auto measured = force_arm(*record, record->load.force(), record->load.moment());
    std::vector<double> factor, arm;
    for (int i = 0; i < points; ++i) {
      const double value = largest * i / (points - 1);
      ModelChoice choice = law.choice;
      choice.model.pillow = {form, value};
      const dragcore::Wrench wrench = predict(*record, choice).total();
      if (const auto model = force_arm(*record, wrench.force, wrench.torque)) factor.push_back(value), arm.push_back(*model);
    }
    if (!measured || arm.size() != points) continue;  // no force, no line of action
    curves.emplace_back(std::move(factor), std::move(arm), 5);
    reference.push_back(*measured);
    used.push_back(record);
  }
  const Problem problem{.parameters = {{form == PillowForm::tilt ? "kappa" : "alpha", 0.0, largest, 0.0, 1.0}},
                        .cases = used,
                        .residual = [=](std::size_t i, const double* k) { return curves[i](k[0]) - reference[i]; }};
  Fit result = fit(problem, "pillow " + to_string(form) + " on law " + law.name, "force arm");
  result.model = {.law = law.choice.model.law, .pillow = {form, std::clamp(result.estimates[0].value, 0.0, largest)}};
  if (law.choice.by_class) result.model.law.name = law.name;
  return result;
}

}  // namespace

namespace {

/// A law with parameters to fit; or those of all classes, in one model.
struct ClassLaw {
  std::string name;
  std::vector<Parameter> parameters;
  std::function<dragcore::Model(const double*)> model;
  bool viscous = false;  ///< at the Reynolds number of each case
};

Fit fit_class_law(const ClassLaw& wanted, const std::vector<const CaseRecord*>& cases) {
  struct Prepared {
    dragcore::Motion motion;
    const dragcore::Surface* surface;
    Eigen::Vector3d reference;
    double scale, weight, viscosity;
  };
  std::map<std::string, dragcore::Surface> surfaces;
  std::vector<Prepared> prepared;
  Problem problem{.parameters = wanted.parameters, .channels = 3, .bootstrap_draws = 200};
  for (const CaseRecord* record : cases) {
    // Facets of 1/48 turn: C_D of round bodies within 1 % of the finest, in a twentieth of the time (second order).
    const bool flat = default_divisions(record->shape) <= 2;
    std::string key = shape_of(*record);
    for (const auto& [name, value] : dragcore::parameters(record->shape)) key += " " + name + std::to_string(value);
    if (!surfaces.contains(key)) surfaces.emplace(key, surface_of(record->shape, flat ? 2 : 12));
    const Eigen::Matrix3d to_wind = record->pose.rotation();
    Prepared one{.surface = &surfaces.at(key)};
    one.viscosity = wanted.viscous ? record->viscosity : 0.0;
    one.motion.wind = to_wind.transpose() * Eigen::Vector3d(record->speed, 0.0, 0.0);
    one.scale = coefficient_scales(*record)[0] / record->density;
    one.reference = to_wind.transpose() * record->load.force() / coefficient_scales(*record)[0];
    // Relative error of the force vector; a force below 0.3 counts as 0.3, or edge-on plates would rule the fit.
    one.weight = 1.0 / std::max(0.3, one.reference.norm());
    prepared.push_back(one);
    problem.cases.insert(problem.cases.end(), 3, record);
  }
  const auto errors_of = [&prepared](std::size_t i, const dragcore::Model& model) -> Eigen::Vector3d {
    const Prepared& one = prepared[i];
    const dragcore::Medium medium{.density = 1.0, .viscosity = one.viscosity};
    return one.weight * (wrench(*one.surface, one.motion, medium, model).total().force / one.scale - one.reference);
  };
  problem.residual = [&](std::size_t i, const double* k) { return errors_of(i / 3, wanted.model(k))[static_cast<Eigen::Index>(i % 3)]; };
  problem.residuals = [&](const std::vector<std::size_t>& subset, const double* k, double* out) {
    const dragcore::Model model = wanted.model(k);
    Eigen::Vector3d errors;
    for (std::size_t j = 0; j < subset.size(); ++j) {  // the three channels of a case follow each other
      if (subset[j] % 3 == 0) errors = errors_of(subset[j] / 3, model);
      out[j] = errors[static_cast<Eigen::Index>(subset[j] % 3)];
    }
  };
  Fit result = fit(problem, "law " + wanted.name, "force vector");
  std::vector<double> best;  // three decimals: intervals are wider, and people read them
  for (const Estimate& estimate : result.estimates) best.push_back(std::round(1e3 * estimate.value) / 1e3);
  result.model = wanted.model(best.data());
  return result;
}

}  // namespace

Calibration calibrate_class_laws(const std::vector<CaseRecord>& records) {
  std::vector<const CaseRecord*> sheets, closed;
  for (const CaseOfRecord& chosen : cases_of_record(records)) {
    const CaseRecord& record = *chosen.family.record;
    if (!is_usable(record.status) || chosen.held_out || record.reynolds < 1e4 || !record.knows_force()) continue;
    const dragcore::Surface surface = surface_of(record.shape, 8);
    (surface.body_class == dragcore::BodyClass::sheet ? sheets : closed).push_back(&record);
  }
  // The difference quotient of the fit must not step over a bound of the law itself: hence 1e-4 instead of 0.
  const ClassLaw sheet{.name = "sheet",
                       .parameters = {{"windward c", 0.0, 4.0, 2.0, 2.0, 1.9}, {"windward c^2", -3.0, 3.0, -1.0, -1.0, -0.5}},
                       .model = [](const double* k) {
                         dragcore::Law law = dragcore::sheet_law();
                         law.windward = {0.0, k[0], k[1], 0.0, 0.0};
                         return dragcore::Model{.law = law};
                       }};
  const ClassLaw other{.name = "closed",
                       .parameters = {{"windward scale", 1e-4, 3.0, 1.0, 1.0, 0.8},
                                      {"base_suction", 1e-4, 3.0, 1e-4, 1e-4, 0.36},
                                      {"recovery_depth", 0.05, 20.0, 20.0, 20.0, 1.0},
                                      {"shelter", 1e-4, 10.0, 1e-4, 1e-4, 1.4},
                                      {"curvature", 1e-4, 5.0, 1e-4, 1e-4, 1.0}},
                       .model = [](const double* k) {
                         dragcore::Law law = dragcore::closed_law();
                         law.windward = {0.0, 0.0, 2.0 * k[0], -k[0], 0.0};
                         law.base_suction = k[1];
                         law.recovery_depth = k[2];
                         law.shelter = k[3];
                         law.curvature = k[4];
                         return dragcore::Model{.law = law};
                       }};
  Calibration calibration;
  for (const auto& [law, cases] : {std::pair(&sheet, &sheets), std::pair(&other, &closed)}) {
    if (cases->size() < 2 * law->parameters.size())
      throw std::invalid_argument("calibrate: " + std::to_string(cases->size()) + " usable cases for the law '" + law->name +
                                  "' at Re >= 1e4 that are not held out, but at least " + std::to_string(2 * law->parameters.size()) +
                                  " are needed; solve more of the matrix `reference`");
    calibration.fits.push_back(fit_class_law(*law, *cases));
  }
  return calibration;
}

Calibration calibrate_viscous_terms(const std::vector<CaseRecord>& records) {
  const ClassLaw viscous{.name = "viscous terms",
                         .parameters = {{"layer", 1e-4, 5.0, 1e-4, 1e-4, 0.75}, {"layer_curvature", 1e-4, 10.0, 1e-4, 1e-4, 1.4}},
                         .model =
                             [](const double* k) {
                               const auto with_terms = [k](dragcore::Law law) {
                                 law.stokes = 1.0, law.layer = k[0], law.layer_curvature = k[1];
                                 return law;
                               };
                               return dragcore::Model{.law = with_terms(dragcore::closed_law()),
                                                      .sheets = dragcore::SheetModel{.law = with_terms(dragcore::sheet_law())}};
                             },
                         .viscous = true};
  std::vector<const CaseRecord*> cases;
  for (const CaseOfRecord& chosen : cases_of_record(records)) {
    const CaseRecord& record = *chosen.family.record;
    if (is_usable(record.status) && !chosen.held_out && record.reynolds < 200.0 && record.viscosity > 0.0 && record.knows_force() &&
        !record.spins())
      cases.push_back(&record);
  }
  if (cases.size() < 4)
    throw std::invalid_argument("calibrate: " + std::to_string(cases.size()) +
                                " usable cases below Re 200 that are not held out, but at least 4 are needed; solve more of the matrix "
                                "`low_reynolds`");
  Calibration calibration;
  calibration.fits.push_back(fit_class_law(viscous, cases));
  return calibration;
}

const Fit& Calibration::fit(const std::string& name) const {
  for (const Fit& candidate : fits)
    if (candidate.name == name) return candidate;
  throw std::out_of_range("no fit named '" + name + "'");
}

std::optional<double> force_arm(const CaseRecord& record, const Eigen::Vector3d& force, const Eigen::Vector3d& moment) {
  const Coefficients c = coefficients(record, force, moment);
  const double size = c.values.head<3>().norm();
  if (size < 1e-3) return std::nullopt;
  return c.values[static_cast<int>(record.pose.yaw != 0.0 ? Channel::yaw : Channel::pitch)] / size;
}

Calibration calibrate(const std::vector<CaseRecord>& records) {
  std::vector<const CaseRecord*> cases;
  for (const CaseOfRecord& chosen : cases_of_record(records)) {
    const CaseRecord& record = *chosen.family.record;
    const std::string shape = shape_of(record);
    if (is_usable(record.status) && !chosen.held_out && record.reynolds >= 1e4 && (shape == "plate" || shape == "cube" || shape == "cone"))
      cases.push_back(&record);
  }
  if (cases.size() < 3)
    throw std::invalid_argument(
        "calibrate: " + std::to_string(cases.size()) +
        " usable cases of plate, cube or cone at Re >= 1e4, but at least 3 are needed; run `dragval run quick` first");
  Calibration calibration;
  calibration.fits.push_back(fit_drag(cases));
  const dragcore::Law fitted = calibration.fits.front().model.law;
  for (const dragcore::Law& law : {dragcore::note_law(), fitted})
    for (const PillowForm form : {PillowForm::triangle, PillowForm::patch, PillowForm::tilt})
      calibration.fits.push_back(fit_pillow(cases, {law.name, dragcore::Model{.law = law}}, form));
  calibration.by_class_pillow = fit_pillow(cases, {"by class", ModelChoice::of_class()}, PillowForm::tilt);
  return calibration;
}

}  // namespace compare
