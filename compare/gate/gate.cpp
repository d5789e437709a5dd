#include "compare/gate/gate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace compare {
namespace {

using case_record::CaseRecord;

/// Collects one check: how many numbers were seen, which were too far off, and the worst that still passed.
class Tally {
 public:
  explicit Tally(std::string name) : name_(std::move(name)) {}

  /// @param excess  how far beyond what is allowed, relative to it: more than 1 fails
  void add(double excess, const std::string& what) {
    ++seen_;
    if (!(excess <= 1.0)) offenders_.push_back(what);
    if (excess > worst_excess_ || worst_.empty()) worst_excess_ = excess, worst_ = what;
  }
  GateCheck result() const {
    constexpr std::size_t shown = 5;  // one defect may turn a hundred numbers red
    GateCheck check{name_, seen_ > 0 && offenders_.empty(), seen_, ""};
    if (seen_ == 0)
      check.detail = "nothing to look at";
    else if (offenders_.empty())
      check.detail = "nearest to its limit: " + worst_;
    else
      check.detail = fmt::format(
          "{} of {} outside: {}", offenders_.size(), seen_,
          fmt::join(offenders_.begin(), offenders_.begin() + static_cast<std::ptrdiff_t>(std::min(shown, offenders_.size())), "; "));
    return check;
  }

 private:
  std::string name_;
  int seen_ = 0;
  std::vector<std::string> offenders_;
  double worst_excess_ = 0.0;
  std::string worst_;
};

/// A value, or its absence, against what the baseline has.
void compare_values(Tally& tally, const std::string& where, const std::optional<double>& now, const std::optional<double>& was) {
  if (!now && !was) return;
  if (!now || !was)
    tally.add(2.0, fmt::format("{} is {}defined, was {}", where, now ? "" : "un", was ? "defined" : "undefined"));
  else
    tally.add(std::abs(*now - *was) / (rounding * std::max(1.0, std::abs(*was))),
              fmt::format("{} {:.9f}, baseline {:.9f}", where, *now, *was));
}

/// How far two uncertainties are apart, over what is rounding.
double uncertainty_excess(double now, double was) { return std::abs(now - was) / std::max(rounding, 1e-6 * std::abs(now)); }

void check_budget(Tally& tally, const std::string& where, double budget, double standing) {
  const bool sound = budget > 0.0 && budget <= standing;
  tally.add(sound ? 0.0 : 2.0, fmt::format("{} budget {:g}, above 0 and at most {:g} needed{}", where, budget, standing,
                                           sound ? "" : "; dragval baseline accept puts it right"));
}

/// The rms errors that a baseline states against those that its own cases make.
void check_group_errors(Tally& tally, const Baseline::Model& accepted, const std::map<std::string, std::string>& family_of) {
  std::map<std::pair<std::string, std::string>, std::pair<double, int>> squares;
  for (const auto& [case_name, channels] : accepted.cases) {
    const auto family = family_of.find(case_name);
    if (family == family_of.end()) return;  // a case has gone, of whichever group: coverage fails
    for (const auto& [channel, entry] : channels)
      if (entry.model && entry.cfd) {
        auto& [sum, n] = squares[{family->second, channel}];
        sum += (*entry.model - *entry.cfd) * (*entry.model - *entry.cfd), ++n;
      }
  }
  for (const auto& [group, sum] : squares) {
    const auto& [family, channel] = group;
    const auto found = accepted.groups.find(family);
    if (found == accepted.groups.end() || !found->second.contains(channel)) {
      tally.add(2.0, fmt::format("{} {} has no rms error in the baseline", family, channel));
      continue;
    }
    const Baseline::Group& stated = found->second.at(channel);
    const double rms = std::sqrt(sum.first / sum.second);
    tally.add(std::abs(stated.rms - rms) / (rounding * std::max(1.0, rms)),
              fmt::format("{} {} rms error {:.6g} in the baseline, {:.6g} by its own cases", family, channel, stated.rms, rms));
    check_budget(tally, family + " " + channel, stated.budget, standing_group_budget);
  }
}

void check_null_channels(Tally& tally, const CaseFamily& family, const dragcore::Wrench& predicted) {
  // A triangulation need not share every mirror plane of its body (diagonals, facets): a thousandth of q A_ref is far above that and far
  // below any flipped or mixed axis. References: what their own uncertainty says, at least 2 % for a steady wake that leans to one side.
  constexpr double null_prediction = 1e-3, null_reference = 0.02;
  const CaseRecord& record = *family.record;
  const auto scales = coefficient_scales(record);
  const auto ours = coefficients(record, predicted.force, predicted.torque).values;
  const auto theirs = coefficients(record).values;
  const auto null = null_channels(record);
  for (std::size_t k = 0; k < null.size(); ++k) {
    if (!null[k]) continue;
    const auto index = static_cast<Eigen::Index>(k);
    const std::string where = record.name + " " + symbol(static_cast<Channel>(k));
    tally.add(std::abs(ours[index]) / null_prediction,
              fmt::format("{} {:+.2e} predicted, at most {:.0e}", where, ours[index], null_prediction));
    const double allowed = std::max(null_reference, 3.0 * family.uncertainty.numerical[index] / scales[index]);
    tally.add(std::abs(theirs[index]) / allowed, fmt::format("{} {:+.2e} in the reference, at most {:.2g}", where, theirs[index], allowed));
  }
}

}  // namespace

bool same_uncertainty(double a, double b) { return uncertainty_excess(a, b) <= 1.0; }

bool GateResult::passed() const {
  return complete() && !checks.empty() && std::all_of(checks.begin(), checks.end(), [](const GateCheck& check) { return check.passed; });
}

GateResult run_gate(const Baseline& baseline, const std::vector<CaseRecord>& records, const std::vector<NamedModel>& models,
                    const std::function<Predictor(const NamedModel&)>& predictor_of) {
  GateResult result;
  result.planned = static_cast<int>(baseline.planned.size());
  std::map<std::string, std::size_t> compared;  // in how many of the models
  const std::vector<CaseOfRecord> records_of_pose = cases_of_record(records);
  for (const NamedModel& named : models) {
    const auto found = baseline.models.find(named.name);
    if (found == baseline.models.end()) {
      result.checks.push_back({named.name, false, 0, "not in the baseline; see dragval baseline diff, then accept it with a reason"});
      continue;
    }
    const Baseline::Model& accepted = found->second;
    const Predictor predict_case = predictor_of(named);
    const ErrorTable table = compare_with(records, predict_case, named.name);
    Tally terms(named.name + ": terms of the baseline"), predictions(named.name + ": predictions"), references(named.name + ": references"),
        groups(named.name + ": group error"), cases(named.name + ": case error"), signs(named.name + ": signs"),
        null(named.name + ": null channels");

    std::map<std::pair<std::string, std::string>, const ErrorRow*> rows;
    std::map<std::string, std::string> family_of;
    for (const ErrorRow& row : table.rows) {
      rows[{row.case_name, symbol(row.channel)}] = &row;
      family_of[row.case_name] = row.family;
    }
    check_budget(terms, "a case:", baseline.case_budget, standing_case_budget);
    check_group_errors(terms, accepted, family_of);
    for (const auto& [case_name, channels] : accepted.cases)
      for (const auto& [channel, was] : channels) {
        const std::string where = case_name + " " + channel;
        const auto row = rows.find({case_name, channel});
        const ErrorRow now = row == rows.end() ? ErrorRow{} : *row->second;
        if (now.cfd && channel == symbol(Channel::drag)) ++compared[case_name];
        // A case that has gone is the business of coverage; a channel of a case that is there is ours.
        if (!rows.contains({case_name, symbol(Channel::drag)})) continue;
        compare_values(predictions, where, now.model, was.model);
        compare_values(references, where, now.cfd, was.cfd);
        terms.add(uncertainty_excess(now.u_numerical, was.u),
                  fmt::format("{} u {:.6g} in the baseline, {:.6g} by the references", where, was.u, now.u_numerical));
        if (was.model && now.model && std::abs(*was.model) > 0.01)
          signs.add(*was.model * *now.model > 0.0 ? 0.0 : 2.0, fmt::format("{} {:+.4f}, baseline {:+.4f}", where, *now.model, *was.model));
        if (was.model && was.cfd && now.error) {
          const double before = std::abs(*was.model - *was.cfd), after = std::abs(*now.error);
          const double allowed = std::max(baseline.case_budget, 2.0 * now.u_numerical);
          cases.add((after - before) / allowed,
                    fmt::format("{} |error| {:.4f}, was {:.4f}, may grow by {:.4f}", where, after, before, allowed));
        }
      }
    for (const ErrorSummary& summary : table.summaries) {
      const auto group = accepted.groups.find(summary.group);
      if (group == accepted.groups.end() || !group->second.contains(symbol(summary.channel))) continue;  // new cases: until accepted
      const Baseline::Group& was = group->second.at(symbol(summary.channel));
      groups.add((summary.rms - was.rms) / was.budget, fmt::format("{} {} rms error {:.4f}, was {:.4f}, may grow by {:.4f}", summary.group,
                                                                   symbol(summary.channel), summary.rms, was.rms, was.budget));
    }
    for (const CaseOfRecord& chosen : records_of_pose)
      if (const CaseFamily& family = chosen.family; case_record::is_usable(family.record->status))
        check_null_channels(null, family, predict_case(*family.record));
    for (const Tally* tally : {&terms, &predictions, &references, &groups, &cases, &signs, &null}) result.checks.push_back(tally->result());
  }
  // A case counts when every model was compared on it: one that is missing from a single model is a hole too.
  const auto everywhere = [&](const std::string& name) { return compared[name] == models.size(); };
  for (const std::string& name : baseline.planned) result.compared += static_cast<int>(everywhere(name));
  GateCheck coverage{"coverage", result.complete(), result.compared,
                     fmt::format("{} of {} planned cases compared", result.compared, result.planned)};
  for (const std::string& name : baseline.planned)
    if (!everywhere(name)) coverage.detail += "; without a usable reference, or left out of a model: " + name;
  result.checks.push_back(std::move(coverage));
  return result;
}

GateCheck check_solved_again(const Baseline& baseline, const std::vector<CaseRecord>& stored, const std::vector<CaseRecord>& solved,
                             double budget) {
  constexpr double stop_tolerance = 0.003;
  Tally tally("solved again");
  for (const CaseRecord& run : solved) {
    const std::string name = seeded_name(run.name).base;
    const auto found = std::find_if(stored.begin(), stored.end(), [&](const CaseRecord& record) { return record.name == name; });
    if (found == stored.end() || !case_record::is_usable(found->status) || !case_record::is_usable(run.status)) {
      tally.add(2.0, fmt::format("{}: {} now, {} in the references", run.name, case_record::to_string(run.status),
                                 found == stored.end() ? "missing" : case_record::to_string(found->status)));
      continue;
    }
    const auto now = coefficients(run).values, was = coefficients(*found).values;
    const CaseRecord::Channels u = (run.own_variance() + found->own_variance()).cwiseSqrt().cwiseQuotient(coefficient_scales(run));
    const auto scatter = baseline.seed_scatter.find(name);
    for (int k = 0; k < 6; ++k) {
      const double seeds = scatter == baseline.seed_scatter.end() ? 0.0 : seed_factor * scatter->second[static_cast<std::size_t>(k)];
      if (budget > 0.0 && budget * std::abs(was[0]) < seeds)
        throw std::invalid_argument(
            fmt::format("--solved-budget {:g}: meshes of {} that differ in their seed alone are apart by {:.5f} in {} (five standard "
                        "deviations of a difference), "
                        "{:.3g} of C_D; at least that is needed, or unchanged code fails",
                        budget, name, seeds, symbol(static_cast<Channel>(k)), seeds / std::abs(was[0])));
      const double allowed = budget > 0.0 ? budget * std::abs(was[0]) : std::max({2.0 * u[k], stop_tolerance * std::abs(was[0]), seeds});
      tally.add(std::abs(now[k] - was[k]) / allowed, fmt::format("{} {} {:.5f}, stored {:.5f}, may be apart by {:.5f}", run.name,
                                                                 symbol(static_cast<Channel>(k)), now[k], was[k], allowed));
    }
  }
  return tally.result();
}

}  // namespace compare
