#include "compare/gate/baseline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "compare/gate/gate.hpp"

namespace compare {
namespace {

using nlohmann::json;

constexpr const char* schema = "dragval baseline 1";

/// The budget of an earlier baseline, where it is one.
double kept_budget(double previous, double standing) { return previous > 0.0 && previous <= standing ? previous : standing; }

json optional_json(const std::optional<double>& value) { return value ? json(*value) : json(nullptr); }
std::optional<double> optional_from(const json& value) { return value.is_null() ? std::nullopt : std::optional(value.get<double>()); }

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  return fmt::format("{:04}-{:02}-{:02}", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday);
}

std::string number(const std::optional<double>& value) { return value ? fmt::format("{:.6f}", *value) : "none"; }

bool same(const std::optional<double>& a, const std::optional<double>& b) {
  return a.has_value() == b.has_value() && (!a || std::abs(*a - *b) <= rounding * std::max(1.0, std::abs(*a)));
}

}  // namespace

std::vector<NamedModel> gated_models() {
  using dragcore::Model;
  using dragcore::PillowForm;
  return {
      {"note", Model{}},
      {"note, patch pillow 1", Model{.law = dragcore::note_law(), .pillow = {PillowForm::patch, 1.0}}},
      {"note, tilt pillow 0.9", Model{.law = dragcore::note_law(), .pillow = {PillowForm::tilt, 0.9}}},
      {"consistent, tilt pillow 0.9", Model{.law = dragcore::consistent_law(), .pillow = {PillowForm::tilt, 0.9}}},
      {"scaled 0.89 suction 0.25, tilt pillow 1.36", Model{.law = dragcore::scaled_law(0.89, 0.25), .pillow = {PillowForm::tilt, 1.36}}},
      {"by class, tilt pillow by class", ModelChoice::recommended()}};
}

Predictor predictor_of_choice(const NamedModel& named) { return predictor(named.choice); }

SeededName seeded_name(const std::string& case_name) {
  const auto at = case_name.rfind("_seed-");
  if (at == std::string::npos) return {case_name};
  int seed = 0;
  const char* const end = case_name.data() + case_name.size();
  const auto [stop, fault] = std::from_chars(case_name.data() + at + 6, end, seed);
  return fault == std::errc() && stop == end ? SeededName{case_name.substr(0, at), seed} : SeededName{case_name};
}

std::map<std::string, std::array<double, 6>> scatter_over_seeds(const std::vector<case_record::CaseRecord>& records) {
  constexpr std::size_t fewest = 5;
  std::map<std::string, std::vector<case_record::CaseRecord::Channels>> by_case;
  for (const case_record::CaseRecord& record : records)
    if (const auto [base, seed] = seeded_name(record.name); seed > judged_seeds && case_record::is_usable(record.status))
      by_case[base].push_back(coefficients(record).values);
  std::map<std::string, std::array<double, 6>> scatter;
  for (const auto& [name, values] : by_case) {
    if (values.size() < fewest) continue;
    case_record::CaseRecord::Channels mean = case_record::CaseRecord::Channels::Zero(), squares = mean;
    for (const auto& value : values) mean += value / static_cast<double>(values.size());
    for (const auto& value : values) squares += (value - mean).cwiseAbs2() / static_cast<double>(values.size() - 1);
    for (int k = 0; k < 6; ++k) scatter[name][static_cast<std::size_t>(k)] = std::sqrt(squares[k]);
  }
  return scatter;
}

Baseline make_baseline(const std::vector<case_record::CaseRecord>& records, const std::string& reason, const Baseline& previous,
                       const std::vector<NamedModel>& models) {
  if (reason.empty()) throw std::invalid_argument("a baseline needs a reason, which stays in it: --reason \"why the errors may change\"");
  Baseline baseline;
  baseline.history = previous.history;
  baseline.history.push_back({today(), reason});
  baseline.case_budget = kept_budget(previous.case_budget, standing_case_budget);
  baseline.seed_scatter = previous.seed_scatter;
  for (const NamedModel& named : models) {
    const ErrorTable table = compare_with(records, predictor(named.choice), named.name);
    Baseline::Model& model = baseline.models[named.name];
    std::set<std::string> planned;
    for (const ErrorRow& row : table.rows) {
      if (!row.cfd && row.channel == Channel::drag) continue;  // not usable: nothing to accept
      if (row.status != "steady" && row.status != "statistically_steady") continue;
      // Without the part of the method: a gate sees the same references twice, and what their equations leave open excuses no change.
      model.cases[row.case_name][symbol(row.channel)] = {row.model, row.cfd, row.u_numerical};
      planned.insert(row.case_name);
    }
    for (const ErrorSummary& summary : table.summaries) {
      double budget = standing_group_budget;
      if (const auto old = previous.models.find(named.name); old != previous.models.end())
        if (const auto group = old->second.groups.find(summary.group); group != old->second.groups.end())
          if (const auto entry = group->second.find(symbol(summary.channel)); entry != group->second.end())
            budget = kept_budget(entry->second.budget, standing_group_budget);
      model.groups[summary.group][symbol(summary.channel)] = {summary.rms, budget};
    }
    baseline.planned.assign(planned.begin(), planned.end());
  }
  if (baseline.planned.empty()) throw std::invalid_argument("no usable case to make a baseline of; run a matrix and collect it first");
  return baseline;
}

Baseline read_baseline(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file)
    throw std::invalid_argument(
        fmt::format("no baseline at {0}; restore it from version control, or make one: dragval baseline accept --baseline {0} --reason "
                    "\"...\", with the "
                    "--law of the gate where it has one",
                    path.string()));
  try {
    const json document = json::parse(file);
    if (document.at("schema") != schema)
      throw std::runtime_error(fmt::format("schema is {}, '{}' is needed", document.at("schema").dump(), schema));
    Baseline baseline;
    for (const json& entry : document.at("history")) baseline.history.push_back({entry.at("date"), entry.at("reason")});
    baseline.case_budget = document.at("case_budget");
    baseline.planned = document.at("planned").get<std::vector<std::string>>();
    for (const auto& [name, model] : document.at("models").items()) {
      Baseline::Model& target = baseline.models[name];
      for (const auto& [case_name, channels] : model.at("cases").items())
        for (const auto& [channel, entry] : channels.items())
          target.cases[case_name][channel] = {optional_from(entry.at("model")), optional_from(entry.at("cfd")), entry.at("u")};
      for (const auto& [group, channels] : model.at("groups").items())
        for (const auto& [channel, entry] : channels.items()) target.groups[group][channel] = {entry.at("rms"), entry.at("budget")};
    }
    if (document.contains("seed_scatter"))
      baseline.seed_scatter = document.at("seed_scatter").get<std::map<std::string, std::array<double, 6>>>();
    return baseline;
  } catch (const std::exception& error) {
    throw std::invalid_argument(fmt::format("{} is not a baseline: {}; restore it from version control", path.string(), error.what()));
  }
}

void write_baseline(const std::filesystem::path& path, const Baseline& baseline) {
  json document = {{"schema", schema}, {"case_budget", baseline.case_budget}, {"planned", baseline.planned}};
  for (const auto& acceptance : baseline.history) document["history"].push_back({{"date", acceptance.date}, {"reason", acceptance.reason}});
  for (const auto& [name, model] : baseline.models) {
    json& target = document["models"][name];
    for (const auto& [case_name, channels] : model.cases)
      for (const auto& [channel, entry] : channels)
        target["cases"][case_name][channel] = {{"model", optional_json(entry.model)}, {"cfd", optional_json(entry.cfd)}, {"u", entry.u}};
    for (const auto& [group, channels] : model.groups)
      for (const auto& [channel, entry] : channels) target["groups"][group][channel] = {{"rms", entry.rms}, {"budget", entry.budget}};
  }
  if (!baseline.seed_scatter.empty()) document["seed_scatter"] = baseline.seed_scatter;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path());
  const std::filesystem::path partial = path.string() + ".partial";
  std::ofstream file(partial);
  file << document.dump(1) << "\n";
  file.close();
  if (!file) throw std::runtime_error("could not write " + partial.string() + "; check space and permissions");
  std::filesystem::rename(partial, path);
}

std::vector<std::string> differences(const Baseline& before, const Baseline& after) {
  std::vector<std::string> lines;
  const auto listed = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const std::string& name : before.planned)
    if (!listed(after.planned, name)) lines.push_back("- case " + name);
  for (const std::string& name : after.planned)
    if (!listed(before.planned, name)) lines.push_back("+ case " + name);
  if (!same(before.case_budget, after.case_budget))
    lines.push_back(fmt::format("budget of a case: {:g} -> {:g}", before.case_budget, after.case_budget));
  for (const auto& [name, model] : after.models) {
    const auto old = before.models.find(name);
    if (old == before.models.end()) {
      lines.push_back("+ model " + name);
      continue;
    }
    for (const auto& [case_name, channels] : model.cases) {
      const auto old_case = old->second.cases.find(case_name);
      if (old_case == old->second.cases.end()) continue;  // told above
      for (const auto& [channel, entry] : old_case->second)
        if (!channels.contains(channel)) lines.push_back(fmt::format("- {} {} {}", name, case_name, channel));
      for (const auto& [channel, entry] : channels) {
        const auto found = old_case->second.find(channel);
        const Baseline::Entry was = found == old_case->second.end() ? Baseline::Entry{} : found->second;
        if (!same(was.model, entry.model))
          lines.push_back(fmt::format("{} {} {}: model {} -> {}", name, case_name, channel, number(was.model), number(entry.model)));
        if (!same(was.cfd, entry.cfd))
          lines.push_back(fmt::format("{} {} {}: CFD {} -> {}", name, case_name, channel, number(was.cfd), number(entry.cfd)));
        if (!same_uncertainty(was.u, entry.u))
          lines.push_back(fmt::format("{} {} {}: u {:.6g} -> {:.6g}", name, case_name, channel, was.u, entry.u));
      }
    }
    for (const auto& [group, channels] : model.groups)
      for (const auto& [channel, entry] : channels) {
        const auto old_group = old->second.groups.find(group);
        if (old_group == old->second.groups.end() || !old_group->second.contains(channel)) continue;
        const Baseline::Group& was = old_group->second.at(channel);
        if (!same(was.rms, entry.rms))
          lines.push_back(fmt::format("{} [{}] {}: rms error {:.6f} -> {:.6f}", name, group, channel, was.rms, entry.rms));
        if (!same(was.budget, entry.budget))
          lines.push_back(fmt::format("{} [{}] {}: budget {:g} -> {:g}", name, group, channel, was.budget, entry.budget));
      }
  }
  for (const auto& [name, model] : before.models)
    if (!after.models.contains(name)) lines.push_back("- model " + name);
  return lines;
}

}  // namespace compare
