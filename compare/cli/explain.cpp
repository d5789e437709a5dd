#include <fmt/format.h>  // before any header of compare: fmt has a function of that name

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "cfd_cases/campaign/slurm.hpp"
#include "cfd_cases/programs/subprocess.hpp"
#include "compare/cli/campaign_options.hpp"
#include "compare/cli/commands.hpp"
#include "compare/gate/baseline.hpp"
#include "compare/tables/explanation.hpp"

namespace cli {

namespace {

namespace fs = std::filesystem;

/// Leaves of two descriptions that differ: what made an older run of the same name stale.
std::vector<std::string> differences(const std::string& then, const std::string& now) {
  std::vector<std::string> lines;
  const auto old_text = nlohmann::json::parse(then, nullptr, false), new_text = nlohmann::json::parse(now);
  if (old_text.is_discarded()) return {"its description cannot be read"};
  for (const auto& change : nlohmann::json::diff(old_text, new_text)) {
    const nlohmann::json::json_pointer at(change.at("path").get<std::string>());
    const auto show = [&](const nlohmann::json& text) { return text.contains(at) ? text.at(at).dump() : "nothing"; };
    lines.push_back(fmt::format("{}: {} then, {} now", at.to_string(), show(old_text), show(new_text)));
  }
  return lines;
}

/// Newest log of a case folder.
fs::path newest_log(const fs::path& folder) {
  fs::path newest;
  if (!fs::exists(folder)) return newest;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().filename().string().starts_with("log.") && (newest.empty() || entry.last_write_time() > fs::last_write_time(newest)))
      newest = entry.path();
  return newest;
}

nlohmann::json explain(const cfd_cases::PlannedCase& planned, const CampaignInput& input,
                       const std::map<std::string, cfd_cases::SlurmTask>& tasks) {
  const cfd_cases::Cache cache{input.cache};
  nlohmann::json text{{"name", planned.spec.name},
                      {"key", planned.identity.key},
                      {"attempts", nlohmann::json::array()},
                      {"differs_from_stored", nlohmann::json::array()}};
  text["rerun"] = fmt::format("dragval run {} --only {} --retry-failed --cache {}", input.matrix, planned.spec.name, input.cache);
  if (planned.cached) {
    text["state"] = case_record::to_string(planned.cached->status);
    text["reason"] = planned.cached->reason;
    text["finished"] = planned.cached->finished;
    for (const auto& attempt : planned.cached->attempts)
      text["attempts"].push_back(
          {{"recipe", attempt.recipe}, {"status", case_record::to_string(attempt.status)}, {"reason", attempt.reason}});
  } else {
    text["state"] = "to solve";
    text["reason"] = "no run of this name is stored";
    // A case that ends, well or badly, is stored. A folder without a run is one at work, or one that was stopped.
    if (fs::exists(cache.work(planned.identity.key))) {
      const bool at_work = fs::exists(cache.lock(planned.identity.key)) && !cfd_cases::FileLock(cache.lock(planned.identity.key)).held();
      text["state"] = at_work ? "running" : "interrupted";
      text["reason"] = at_work ? "another dragval run is at work on it" : "the run was stopped before its end; the next one begins again";
    }
    for (const auto& record : compare::read_runs(cache.root / "runs"))
      if (record.name == planned.spec.name) {
        text["stale"] = "a run of this name is stored, but of another description: it is stale";
        text["differs_from_stored"] = differences(record.description, planned.identity.description);
      }
  }
  const fs::path folder = cache.work(planned.identity.key);
  text["folder"] = fs::exists(folder) ? folder.string() : "";
  const fs::path log = newest_log(folder);
  text["log"] = log.string();
  text["log_excerpt"] = log.empty() ? "" : cfd_cases::log_excerpt(log);
  if (const auto task = tasks.find(planned.identity.key); task != tasks.end()) {
    text["slurm"] = task->second.describe();
    text["slurm_log"] = fs::exists(task->second.log) ? task->second.log.string() : "";
    text["slurm_log_excerpt"] = fs::exists(task->second.log) ? cfd_cases::log_excerpt(task->second.log) : "";
  }
  return text;
}

void print(const nlohmann::json& text) {
  const auto word = [&](const char* key) { return text.at(key).get<std::string>(); };
  fmt::print("{}\n  state:    {}\n", word("name"), word("state"));
  if (!word("reason").empty()) fmt::print("  reason:   {}\n", word("reason"));
  if (text.contains("stale")) fmt::print("  stale:    {}\n", word("stale"));
  for (const auto& line : text.at("differs_from_stored")) fmt::print("            {}\n", line.get<std::string>());
  for (const auto& attempt : text.at("attempts"))
    fmt::print("  attempt:  {}: {}{}{}\n", attempt.at("recipe").get<std::string>(), attempt.at("status").get<std::string>(),
               attempt.at("reason") == "" ? "" : ", ", attempt.at("reason").get<std::string>());
  if (!word("log").empty()) fmt::print("  log:      {}\n            {}\n", word("log"), word("log_excerpt"));
  if (text.contains("slurm")) {
    fmt::print("  slurm:    {}\n", word("slurm"));
    if (!word("slurm_log").empty()) fmt::print("            {}\n            {}\n", word("slurm_log"), word("slurm_log_excerpt"));
  }
  fmt::print("  folder:   {}\n  key:      {}\n  rerun:    {}\n", word("folder").empty() ? "not kept" : word("folder"), word("key"),
             word("rerun"));
}

}  // namespace

void add_explain(CLI::App& app, Context&) {
  struct Options {
    CampaignInput input;
    std::string pose, store = "results/reference.h5";
    double reynolds = 1e5;
    ModelOptions model;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("explain",
                         "BODY POSE: how wrong the model is there, whether that is real, where it comes from and what would halve it.\n"
                         "CASE: why a case is missing, stale or failed: attempts, log, folder and the command to repeat it");
  command->add_option("case", options->input.only, "name of a case, part of one, or a pattern; with a pose, a body: cube, 'plate span=3'")
      ->required();
  command->add_option("pose", options->pose, "degrees: 30, 'yaw 45', 'incidence 20 yaw 15'");
  command->add_option("--re", options->reynolds, "Reynolds number of the pose")->capture_default_str();
  command->add_option("--store", options->store, "references of the pose")->capture_default_str();
  add_model_options(*command, options->model);
  command->add_option("--matrix", options->input.matrix, "smoke, quick, reference or a TOML file")->capture_default_str();
  command->add_option("--cache", options->input.cache, "folder of solved cases")->capture_default_str();
  command->add_flag("--json", options->json, "machine-readable");
  command->footer("Examples:\n  dragval explain cube 'yaw 45'\n  dragval explain plate_incidence-030_re-1e5_medium");
  command->callback([options] {
    nlohmann::json list = nlohmann::json::array();
    if (!options->pose.empty()) {
      const compare::PoseQuestion question = compare::pose_question(options->input.only, options->pose, options->reynolds);
      const compare::Reference reference = load({.store = options->store}).reference;
      const compare::NamedModel asked{options->model.label(), options->model.model()};
      for (const compare::Explanation& found : compare::explain_error(reference, asked, compare::gated_models(), question)) {
        if (options->json)
          list.push_back(compare::to_json(found));
        else
          std::cout << compare::render(found);
      }
      if (options->json) std::cout << list.dump(2) << "\n";
      return;
    }
    const auto tasks = cfd_cases::slurm_tasks({options->input.cache});
    for (const auto& planned : plan_cases(options->input, cfd_cases::find_tools())) list.push_back(explain(planned, options->input, tasks));
    if (options->json)
      std::cout << list.dump(2) << "\n";
    else
      for (const auto& text : list) print(text);
  });
}

}  // namespace cli
