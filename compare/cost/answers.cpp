#include "compare/cost/answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace compare {
namespace {

using nlohmann::json;

std::string percent(double share) {
  if (share > 0.0 && share < 5e-5) return "< 0.01 %";
  return fmt::format("{:.{}f} %", 100.0 * share, share < 0.00995 ? 2 : share < 0.9995 ? 1 : 0);
}

/// "class, pillow, on 1,024 triangles"
std::string described(const Rung& rung) {
  if (rung.kind == "CFD") return fmt::format("OpenFOAM, {}", rung.name);
  return rung.triangles > 0.0 ? fmt::format("'{}' on {:.0f} triangles", rung.name, rung.triangles) : "'" + rung.name + "'";
}

std::string priced(const Rung& rung) { return fmt::format("{} for {}", percent(rung.errors.relative), time_text(rung.seconds)); }

std::string pose_count(const Ladder& ladder) {
  return fmt::format("{} pose{} of {} bod{}", ladder.poses, ladder.poses == 1 ? "" : "s", ladder.bodies, ladder.bodies == 1 ? "y" : "ies");
}

/// The cheapest of those that are as near as the nearest.
const Rung* best_of(const std::vector<Rung>& rungs, bool cfd) {
  const Rung* nearest = nullptr;
  for (const Rung& rung : rungs)
    if ((rung.kind == "CFD") == cfd && (!nearest || rung.errors.relative < nearest->errors.relative)) nearest = &rung;
  const Rung* best = nearest;
  for (const Rung& rung : rungs)
    if ((rung.kind == "CFD") == cfd && nearer * rung.errors.relative <= nearest->errors.relative && rung.seconds < best->seconds)
      best = &rung;
  return best;
}

}  // namespace

std::vector<const Rung*> pareto_front(const std::vector<Rung>& rungs) {
  std::vector<const Rung*> sorted, front;
  int poses = 0;
  for (const Rung& rung : rungs) poses = std::max(poses, rung.poses);
  for (const Rung& rung : rungs)
    if (2 * rung.poses >= poses) sorted.push_back(&rung);  // an rms over a few poses is another question
  std::sort(sorted.begin(), sorted.end(), [](const Rung* a, const Rung* b) { return a->seconds < b->seconds; });
  for (const Rung* rung : sorted)
    if (front.empty() || rung->errors.relative < nearer * front.back()->errors.relative) front.push_back(rung);
  return front;
}

std::vector<FrontStep> front_steps(const std::vector<const Rung*>& front) {
  std::vector<FrontStep> steps;
  for (std::size_t i = 1; i < front.size(); ++i) {
    const Rung &from = *front[i - 1], &to = *front[i];
    const double cost = to.seconds / from.seconds;
    steps.push_back({&from, &to, cost, std::pow(cost, std::log(2.0) / std::log(from.errors.relative / to.errors.relative))});
  }
  return steps;
}

std::vector<FrontStep> halvings(const std::vector<const Rung*>& front) {
  std::vector<FrontStep> steps;
  if (front.empty()) return steps;
  const Rung* from = front.front();
  for (const Rung* rung : front)
    if (rung->errors.relative <= 0.5 * from->errors.relative) {
      const double cost = rung->seconds / from->seconds;
      steps.push_back({from, rung, cost, cost});
      from = rung;
    }
  return steps;
}

TargetAnswer reach(const Ladder& ladder, double target) {
  TargetAnswer found{.target = target, .best_law = best_of(ladder.rungs, false), .best_cfd = best_of(ladder.rungs, true)};
  for (const Rung& rung : ladder.rungs) {
    const Rung*& cheapest = rung.kind == "CFD" ? found.cfd : found.law;
    if (rung.errors.relative <= target && (!cheapest || rung.seconds < cheapest->seconds)) cheapest = &rung;
  }
  return found;
}

std::string time_text(double seconds) {
  constexpr std::array<std::pair<double, const char*>, 6> units = {
      {{1e-9, "ns"}, {1e-6, "\u00b5s"}, {1e-3, "ms"}, {1.0, "s"}, {60.0, "min"}, {3600.0, "h"}}};
  auto unit = units.front();
  for (const auto& larger : units)
    if (seconds >= 0.9995 * larger.first) unit = larger;
  const double value = seconds / unit.first;
  return fmt::format("{:.{}f} {}", value, value < 9.95 ? 1 : 0, unit.second);
}

std::string times_text(double factor) {
  if (factor < 9.95) return fmt::format("\u00d7 {:.1f}", factor);
  if (factor < 9999.5) return fmt::format("\u00d7 {:.0f}", factor);
  const double exponent = std::floor(std::log10(factor) + 0.0222);  // from 9.5 on the digit is a 1 again
  return fmt::format("\u00d7 {:.0f}e{:.0f}", factor / std::pow(10.0, exponent), exponent);
}

std::string answer(const Ladder& ladder) {
  const Rung *law = best_of(ladder.rungs, false), *cfd = best_of(ladder.rungs, true);
  std::string text = fmt::format("Nearest without CFD: {}, {}.\n", described(*law), priced(*law));
  if (cfd) text += fmt::format("Nearest mesh of CFD: {}, {} ({} of the poses).\n", described(*cfd), priced(*cfd), cfd->poses);
  text += fmt::format("The references are known to {} (one standard uncertainty, what their equations leave open included).\n",
                      percent(ladder.uncertainty.relative));
  text += fmt::format("Errors are rms over {} at Re 1e5: of the force vector, over the rms force of its body.\n", pose_count(ladder));
  const std::vector<const Rung*> front = pareto_front(ladder.rungs);
  const std::vector<FrontStep> steps = halvings(front);
  for (const FrontStep& step : steps)
    text += fmt::format("Half the error of {} costs {}: from {} to {}, {}.\n", described(*step.from), times_text(step.times_cost),
                        priced(*step.from), described(*step.to), priced(*step.to));
  const Rung& last = steps.empty() ? *front.front() : *steps.back().to;
  return text +
         fmt::format("Half of the {} of {} is reached by nothing that was measured.\n", percent(last.errors.relative), described(last));
}

std::string answer(const Ladder& ladder, const TargetAnswer& found) {
  const std::string where = fmt::format("{}{}", ladder.body.empty() ? "" : ladder.body + ", ", pose_count(ladder));
  std::string text = fmt::format("{} of the force, rms over {} at Re 1e5: ", percent(found.target), where);
  if (!found.law && !found.cfd)
    text += "nothing that was measured reaches it.\n";
  else
    text += fmt::format("reached by {}.\n", found.law && found.cfd ? "a law and by CFD" : found.law ? "a law" : "CFD alone");
  const auto line = [&](const char* what, const Rung* reached, const Rung* best) {
    if (!best) return fmt::format("  {}  none\n", what);
    const Rung& shown = reached ? *reached : *best;
    std::string words = fmt::format("  {}  {}{}, {}", what, reached ? "" : "not reached; nearest is ", described(shown), priced(shown));
    if (shown.kind == "CFD") words += fmt::format(" ({} of the poses; error of the mesh)", shown.poses);
    return words + "\n";
  };
  text += line("without CFD", found.law, found.best_law);
  text += line("CFD        ", found.cfd, found.best_cfd);
  if (found.law && found.cfd) text += fmt::format("  CFD costs {} as much\n", times_text(found.cfd->seconds / found.law->seconds));
  text += fmt::format("The references themselves are known to {} (one standard uncertainty){}\n", percent(ladder.uncertainty.relative),
                      ladder.uncertainty.relative > found.target ? ": whether this error is reached cannot be told from them." : ".");
  return text;
}

namespace {

std::vector<std::string> cells_of(const std::string& name, double triangles, double seconds, const RmsErrors& errors) {
  return {name,
          triangles > 0.0 ? fmt::format("{:.0f}", triangles) : "",
          time_text(seconds),
          percent(errors.relative),
          fmt::format("{:.3f}", errors.drag),
          fmt::format("{:.3f}", errors.force),
          fmt::format("{:.3f}", errors.torque)};
}

std::vector<std::string> heading(const char* name) { return {name, "triangles, cells", "CPU time", "of the force", "C_D", "C_F", "C_M"}; }

TextGrid front_grid(const Ladder& ladder, const std::vector<const Rung*>& front) {
  TextGrid grid;
  auto head = heading("rung");
  head.insert(head.end(), {"poses", "cost of the last", "for half of it"});
  grid.add(head);
  const std::vector<FrontStep> steps = front_steps(front);
  for (std::size_t i = 0; i < front.size(); ++i) {
    auto cells = cells_of(front[i]->name, front[i]->triangles, front[i]->seconds, front[i]->errors);
    cells.push_back(std::to_string(front[i]->poses));
    cells.push_back(i == 0 ? "" : times_text(steps[i - 1].times_cost));
    // At that pace no machine would live to see it.
    cells.push_back(i == 0 ? "" : steps[i - 1].halving_cost < 1e9 ? times_text(steps[i - 1].halving_cost) : "never");
    grid.add(cells);
  }
  const RmsErrors& u = ladder.uncertainty;
  grid.add({"u of the references", "", "", percent(u.relative), fmt::format("{:.3f}", u.drag), fmt::format("{:.3f}", u.force),
            fmt::format("{:.3f}", u.torque), std::to_string(ladder.poses), "", ""});
  return grid;
}

TextGrid ablation_grid(const Ladder& ladder) {
  const Rung& best = *ladder.rung(best_law);
  TextGrid grid;
  grid.add({"without", "CPU time", "saved", "of the force", "points added", "C_D", "C_M"});
  const auto add = [&](const std::string& name, double seconds, const RmsErrors& errors, bool changed) {
    grid.add({name, time_text(seconds), changed ? fmt::format("{:.0f} %", 100.0 * (1.0 - seconds / best.seconds)) : "",
              percent(errors.relative), changed ? fmt::format("{:+.1f}", 100.0 * (errors.relative - best.errors.relative)) : "",
              fmt::format("{:.3f}", errors.drag), fmt::format("{:.3f}", errors.torque)});
  };
  add("nothing: '" + best.name + "'", best.seconds, best.errors, false);
  for (const Ablation& row : ladder.ablation) add(row.effect, row.seconds, row.errors, true);
  return grid;
}

TextGrid mesh_grid(const Ladder& ladder) {
  TextGrid grid;
  grid.add({"body", "triangles", "CPU time", "drag, of the finest"});
  for (const MeshStep& step : ladder.meshes)
    grid.add({step.body, fmt::format("{:.0f}", step.triangles), time_text(step.seconds), fmt::format("{:.4f}", step.force_ratio)});
  return grid;
}

TextGrid spin_grid(const Ladder& ladder) {
  TextGrid grid;
  grid.add({"rule", "triangles", "CPU time", "of the rule", "of the torque", "cases"});
  for (const SpinStep& step : ladder.spin)
    grid.add({step.rule, fmt::format("{:.0f}", step.triangles), time_text(step.seconds), percent(step.rule_error), percent(step.cfd_error),
              std::to_string(step.cases)});
  return grid;
}

TextGrid step_grid(const Ladder& ladder) {
  TextGrid grid;
  grid.add({"what", "body", "triangles", "CPU time"});
  for (const StepCost& step : ladder.steps)
    grid.add({step.what, step.body, fmt::format("{:.0f}", step.triangles), time_text(step.seconds)});
  return grid;
}

/// "cone 48 and 960": from where on a mesh is within one in a hundred, and in a thousand, of the finest.
std::string enough_triangles(const Ladder& ladder) {
  std::vector<std::string> bodies;
  for (const MeshStep& step : ladder.meshes)
    if (bodies.empty() || bodies.back() != step.body) bodies.push_back(step.body);
  std::string text;
  for (const std::string& body : bodies) {
    const auto from = [&](double tolerance) {
      double triangles = 0.0;
      for (auto step = ladder.meshes.rbegin(); step != ladder.meshes.rend(); ++step) {
        if (step->body != body) continue;
        if (std::abs(step->force_ratio - 1.0) > tolerance) break;
        triangles = step->triangles;
      }
      return triangles;
    };
    text += fmt::format("{}{} {:.0f} and {:.0f}", text.empty() ? "" : ", ", body, from(0.01), from(0.001));
  }
  return text;
}

std::string stopping_text(const Stopping& stop) {
  if (stop.poses == 0) return "";
  std::string text = fmt::format(" A steady solution that stops on its forces leaves a drift of {} of the force.", percent(stop.left));
  if (stop.longer_cost_low)
    text += fmt::format(" Going on to 800 iterations instead costs {:.1f} to {:.1f} times as much; of C_D it changes {}.",
                        *stop.longer_cost_low, *stop.longer_cost_high, percent(stop.longer_change));
  return text;
}

}  // namespace

std::vector<CostTable> cost_tables(const Ladder& ladder) {
  std::vector<CostTable> tables;
  if (ladder.rungs.empty()) return tables;
  tables.push_back({"front-table", "The next halving of the error: rms errors and prices of the rungs that nothing cheaper is as near as",
                    front_grid(ladder, pareto_front(ladder.rungs)),
                    "n: segments of a quarter turn of round bodies, 32 where nothing is said." + stopping_text(ladder.stopping)});
  if (ladder.rung(best_law) && !ladder.ablation.empty())
    tables.push_back(
        {"ablation-table", "Each effect of the best law taken away, the others as they were fitted with it", ablation_grid(ladder)});
  if (!ladder.meshes.empty())
    tables.push_back({"triangles-table", "How many triangles are enough: drag along the axis, law of the class", mesh_grid(ladder),
                      "Within 1 and 0.1 % of the finest from: " + enough_triangles(ladder) + " triangles."});
  if (!ladder.spin.empty())
    tables.push_back({"spin-cost-table", "Points per triangle of bodies that spin: rms error against six points, and of OpenFOAM's torque",
                      spin_grid(ladder)});
  if (!ladder.steps.empty()) tables.push_back({"step-table", "Many bodies, and a step of a body that spins; best law", step_grid(ladder)});
  return tables;
}

CostTable all_rungs(const Ladder& ladder) {
  std::vector<const Rung*> sorted;
  for (const Rung& rung : ladder.rungs) sorted.push_back(&rung);
  std::stable_sort(sorted.begin(), sorted.end(), [](const Rung* a, const Rung* b) { return a->seconds < b->seconds; });
  const std::vector<const Rung*> front = pareto_front(ladder.rungs);
  CostTable table{"rungs-table", "All rungs in order of cost; * nothing cheaper is as near", {}};
  auto head = heading("rung");
  head.insert(head.end(), {"poses", "kind"});
  table.grid.add(head);
  for (const Rung* rung : sorted) {
    const bool on_front = std::find(front.begin(), front.end(), rung) != front.end();
    auto cells = cells_of(rung->name + (on_front ? " *" : ""), rung->triangles, rung->seconds, rung->errors);
    cells.push_back(std::to_string(rung->poses));
    cells.push_back(rung->kind);
    table.grid.add(cells);
  }
  return table;
}

namespace {

json to_json(const RmsErrors& errors) {
  return {{"relative_force", errors.relative}, {"C_D", errors.drag}, {"C_F", errors.force}, {"C_M", errors.torque}};
}

json to_json(const Rung* rung) {
  if (!rung) return nullptr;
  return {{"name", rung->name},
          {"kind", rung->kind},
          {"triangles", rung->triangles},
          {"cpu_s", rung->seconds},
          {"rms_error", to_json(rung->errors)},
          {"poses", rung->poses}};
}

}  // namespace

json to_json(const TargetAnswer& found) {
  return {{"target", found.target},
          {"cheapest_law", to_json(found.law)},
          {"cheapest_cfd", to_json(found.cfd)},
          {"nearest_law", to_json(found.best_law)},
          {"nearest_cfd", to_json(found.best_cfd)}};
}

json to_json(const Ladder& ladder) {
  json document = {
      {"body", ladder.body},    {"poses", ladder.poses},  {"bodies", ladder.bodies},   {"reference_u", to_json(ladder.uncertainty)},
      {"rungs", json::array()}, {"front", json::array()}, {"ablation", json::array()}, {"triangles", json::array()},
      {"spin", json::array()},  {"step", json::array()}};
  for (const Rung& rung : ladder.rungs) document["rungs"].push_back(to_json(&rung));
  const std::vector<const Rung*> front = pareto_front(ladder.rungs);
  const std::vector<FrontStep> steps = front_steps(front);
  for (std::size_t i = 0; i < front.size(); ++i) {
    json entry = {{"name", front[i]->name}};
    entry["times_cost"] = optional_json(i ? std::optional(steps[i - 1].times_cost) : std::nullopt);
    entry["halving_cost"] = optional_json(i ? std::optional(steps[i - 1].halving_cost) : std::nullopt);
    document["front"].push_back(entry);
  }
  for (const Ablation& row : ladder.ablation)
    document["ablation"].push_back({{"without", row.effect}, {"cpu_s", row.seconds}, {"rms_error", to_json(row.errors)}});
  for (const MeshStep& row : ladder.meshes)
    document["triangles"].push_back(
        {{"body", row.body}, {"triangles", row.triangles}, {"cpu_s", row.seconds}, {"force_ratio", row.force_ratio}});
  for (const SpinStep& row : ladder.spin)
    document["spin"].push_back({{"rule", row.rule},
                                {"triangles", row.triangles},
                                {"cpu_s", row.seconds},
                                {"rule_error", row.rule_error},
                                {"torque_error", row.cfd_error},
                                {"cases", row.cases}});
  for (const StepCost& row : ladder.steps)
    document["step"].push_back({{"what", row.what}, {"body", row.body}, {"triangles", row.triangles}, {"cpu_s", row.seconds}});
  const Stopping& stop = ladder.stopping;
  document["stopping"] = {{"left", stop.left},
                          {"poses", stop.poses},
                          {"longer_cost_low", optional_json(stop.longer_cost_low)},
                          {"longer_cost_high", optional_json(stop.longer_cost_high)},
                          {"longer_change", stop.longer_change}};
  return document;
}

}  // namespace compare
