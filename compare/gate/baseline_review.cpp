#include "compare/gate/baseline_review.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "compare/gate/gate.hpp"
#include "compare/tables/text_grid.hpp"

namespace compare {
namespace {

struct Pair {
  const Baseline::Entry *was, *now;
};

/// Calls visit(case, channel, entries) for whatever both have.
template <class Visit>
void for_each_common(const Baseline::Model& before, const Baseline::Model& after, Visit visit) {
  for (const auto& [name, channels] : after.cases) {
    const auto old = before.cases.find(name);
    if (old == before.cases.end()) continue;
    for (const auto& [channel, now] : channels)
      if (const auto was = old->second.find(channel); was != old->second.end()) visit(name, channel, Pair{&was->second, &now});
  }
}

bool moved(const std::optional<double>& a, const std::optional<double>& b) {
  return a.has_value() != b.has_value() || (a && std::abs(*a - *b) > rounding * std::max(1.0, std::abs(*a)));
}

}  // namespace

double BaselineReview::CaseChange::growth_in_u() const { return (std::abs(error_after) - std::abs(error_before)) / std::max(u, 1e-3); }

BaselineReview review(const Baseline& before, const Baseline& after) {
  constexpr std::size_t shown = 10;
  BaselineReview result;
  const std::set<std::string> old_cases(before.planned.begin(), before.planned.end()), cases(after.planned.begin(), after.planned.end());
  for (const std::string& name : cases) result.cases_added += !old_cases.contains(name);
  for (const std::string& name : old_cases) result.cases_removed += !cases.contains(name);
  std::set<std::string> references;
  for (const auto& [model, now_model] : after.models) {
    const auto old = before.models.find(model);
    if (old == before.models.end()) continue;
    std::map<std::string, BaselineReview::Group> groups;
    std::vector<BaselineReview::CaseChange> changes;
    for_each_common(old->second, now_model, [&](const std::string& name, const std::string& channel, const Pair& entry) {
      if (moved(entry.was->cfd, entry.now->cfd) || !same_uncertainty(entry.was->u, entry.now->u)) references.insert(name);
      if (!entry.was->model || !entry.was->cfd || !entry.now->model || !entry.now->cfd) return;
      const BaselineReview::CaseChange change{
          model, name, channel, *entry.was->model - *entry.was->cfd, *entry.now->model - *entry.now->cfd, entry.now->u};
      BaselineReview::Group& group = groups[channel];
      ++group.cases;
      group.rms_before += change.error_before * change.error_before, group.rms_after += change.error_after * change.error_after;
      const double growth = std::abs(change.error_after) - std::abs(change.error_before);
      if (std::abs(growth) <= rounding) return;
      ++(growth < 0.0 ? group.better : group.worse);
      if (std::abs(change.growth_in_u()) > 2.0) ++(growth < 0.0 ? group.better_by_2u : group.worse_by_2u);
      changes.push_back(change);
    });
    for (auto& [channel, group] : groups) {
      if (group.better + group.worse == 0) continue;
      group.model = model, group.channel = channel;
      group.rms_before = std::sqrt(group.rms_before / group.cases), group.rms_after = std::sqrt(group.rms_after / group.cases);
      result.groups.push_back(group);
    }
    std::stable_sort(changes.begin(), changes.end(),
                     [](const auto& a, const auto& b) { return std::abs(a.growth_in_u()) > std::abs(b.growth_in_u()); });
    changes.resize(std::min(shown, changes.size()));
    result.largest.insert(result.largest.end(), changes.begin(), changes.end());
  }
  result.references_changed = static_cast<int>(references.size());
  return result;
}

std::string render(const BaselineReview& review, Format format) {
  if (format == Format::csv) throw std::invalid_argument("--format csv: a review is table, md or json");
  if (format == Format::json) {
    nlohmann::json document = {{"cases_added", review.cases_added},
                               {"cases_removed", review.cases_removed},
                               {"references_changed", review.references_changed},
                               {"groups", nlohmann::json::array()},
                               {"largest", nlohmann::json::array()}};
    for (const auto& g : review.groups)
      document["groups"].push_back({{"model", g.model},
                                    {"channel", g.channel},
                                    {"cases", g.cases},
                                    {"better", g.better},
                                    {"worse", g.worse},
                                    {"better_by_2u", g.better_by_2u},
                                    {"worse_by_2u", g.worse_by_2u},
                                    {"rms_before", g.rms_before},
                                    {"rms_after", g.rms_after}});
    for (const auto& c : review.largest)
      document["largest"].push_back({{"model", c.model},
                                     {"case", c.case_name},
                                     {"channel", c.channel},
                                     {"error_before", c.error_before},
                                     {"error_after", c.error_after},
                                     {"u", c.u},
                                     {"growth_in_u", c.growth_in_u()}});
    return document.dump(2) + "\n";
  }
  const auto grid_text = [&](const TextGrid& grid) { return format == Format::markdown ? markdown(grid) : aligned(grid, false); };
  std::string text = fmt::format("{} cases added, {} removed; the reference of {} is another one\n", review.cases_added,
                                 review.cases_removed, review.references_changed);
  if (review.groups.empty()) return text + "no error of a case that both have changes\n";
  TextGrid groups, cases;
  groups.add({"model", "channel", "cases", "better", "by > 2u", "worse", "by > 2u", "rms error was", "is"});
  for (const auto& g : review.groups)
    groups.add({g.model, g.channel, std::to_string(g.cases), std::to_string(g.better), std::to_string(g.better_by_2u),
                std::to_string(g.worse), std::to_string(g.worse_by_2u), fmt::format("{:.4f}", g.rms_before),
                fmt::format("{:.4f}", g.rms_after)});
  cases.add({"model", "case", "channel", "error was", "is", "u", "|error| grows by [u]"});
  for (const auto& c : review.largest)
    cases.add({c.model, c.case_name, c.channel, fmt::format("{:+.4f}", c.error_before), fmt::format("{:+.4f}", c.error_after),
               fmt::format("{:.4f}", c.u), fmt::format("{:+.1f}", c.growth_in_u())});
  return text + "\n" + grid_text(groups) + "\nThe largest changes:\n\n" + grid_text(cases);
}

}  // namespace compare
