#include <catch2/catch.hpp>
#include <fstream>

#include "compare/gate/baseline_review.hpp"
#include "compare/gate/odds.hpp"
#include "tests/compare/sample_records.hpp"

using Catch::Contains;
using sample::CaseRecord;

namespace {

/// Runs the gate with a defect seeded into every prediction.
template <class Defect>
compare::GateResult with_defect(const std::vector<CaseRecord>& records, Defect defect) {
  const auto baseline = compare::make_baseline(records, "test");
  return compare::run_gate(baseline, records, compare::gated_models(), [&](const compare::NamedModel& named) -> compare::Predictor {
    return [model = compare::predictor(named.choice), defect](const CaseRecord& record) { return defect(record, model); };
  });
}

/// Names of the failed checks of the note's model, comma-separated.
std::string failures(const compare::GateResult& result) {
  std::string names;
  for (const auto& check : result.checks)
    if (!check.passed && check.name.starts_with("note: ")) names += check.name.substr(6) + ", ";
  return names;
}

}  // namespace

TEST_CASE("an unchanged model passes against the baseline made from it", "[compare][gate][analytic]") {
  const auto records = sample::quick_tier();
  const auto result = compare::run_gate(compare::make_baseline(records, "test"), records);
  for (const auto& check : result.checks) {
    INFO(check.name << ": " << check.detail);
    CHECK(check.passed);
    CHECK(check.compared > 0);
  }
  CHECK(result.passed());
  CHECK(result.compared == 12);
}

TEST_CASE("half the reference area turns the gate red", "[compare][gate][regression]") {
  const auto result = with_defect(sample::quick_tier(), [](const CaseRecord& record, const compare::Predictor& model) {
    dragcore::Wrench wrench = model(record);
    wrench.force *= 2.0;  // C = F / (q A): half the area doubles every coefficient
    wrench.torque *= 2.0;
    return wrench;
  });
  CHECK_FALSE(result.passed());
  CHECK_THAT(failures(result), Contains("predictions") && Contains("group error") && Contains("case error"));
}

TEST_CASE("total and pressure force summed turns the gate red", "[compare][gate][regression]") {
  const auto records = sample::quick_tier();
  auto summed = records;
  for (CaseRecord& record : summed) {
    record.load.force_viscous += record.load.force_pressure;
    record.load.moment_viscous += record.load.moment_pressure;
  }
  const auto result = compare::run_gate(compare::make_baseline(records, "test"), summed);
  CHECK_FALSE(result.passed());
  CHECK_THAT(failures(result), Contains("references") && Contains("group error") && Contains("case error"));
}

TEST_CASE("a flipped pitch sign turns the gate red", "[compare][gate][regression]") {
  const auto flip = [](const CaseRecord& record, const compare::Predictor& model) {
    dragcore::Wrench wrench = model(record);
    wrench.torque.y() *= -1.0;
    return wrench;
  };
  const auto result = with_defect(sample::quick_tier(), flip);
  CHECK_FALSE(result.passed());
  CHECK_THAT(failures(result), Contains("predictions") && Contains("signs"));
}

TEST_CASE("degrees taken for radians turn the gate red", "[compare][gate][regression]") {
  const auto result = with_defect(sample::quick_tier(), [](CaseRecord record, const compare::Predictor& model) {
    record.pose.incidence /= sample::deg;
    record.pose.yaw /= sample::deg;
    return model(record);
  });
  CHECK_FALSE(result.passed());
  CHECK_THAT(failures(result), Contains("predictions") && Contains("case error"));
}

TEST_CASE("a torque about the wrong point turns the gate red", "[compare][gate][regression]") {
  const auto result = with_defect(sample::quick_tier(), [](const CaseRecord& record, const compare::Predictor& model) {
    dragcore::Wrench wrench = model(record);
    wrench.torque -= Eigen::Vector3d(0.0, 0.1, 0.0).cross(wrench.force);
    return wrench;
  });
  CHECK_FALSE(result.passed());
  CHECK_THAT(failures(result), Contains("null channels"));
}

TEST_CASE("a change of one part in a million is seen by the check of predictions and by no other", "[compare][gate][limit]") {
  const auto result = with_defect(sample::quick_tier(), [](const CaseRecord& record, const compare::Predictor& model) {
    dragcore::Wrench wrench = model(record);
    wrench.force *= 1.0 + 1e-6;
    return wrench;
  });
  CHECK(failures(result) == "predictions, ");
}

TEST_CASE("rounding passes", "[compare][gate][limit]") {
  const auto result = with_defect(sample::quick_tier(), [](const CaseRecord& record, const compare::Predictor& model) {
    dragcore::Wrench wrench = model(record);
    wrench.force *= 1.0 + 1e-13;
    return wrench;
  });
  CHECK(result.passed());
}

TEST_CASE("a baseline whose uncertainties, budgets or errors were edited is refused, whichever way", "[compare][gate][regression]") {
  // With a budget of 1e9, or with u of 1e9 in one case, every model used to pass.
  const auto records = sample::quick_tier();
  const auto sound = compare::make_baseline(records, "test");
  const auto refused_as = [&](const compare::Baseline& edited) {
    const auto result = compare::run_gate(edited, records);
    CHECK_FALSE(result.passed());
    for (const auto& check : result.checks)
      if (check.name == "note: terms of the baseline") return check.detail;
    return std::string();
  };
  const auto& entries = sound.models.at("note").cases;
  const std::string case_name = entries.begin()->first;
  const auto& [family, errors] = *sound.models.at("note").groups.begin();
  auto edited = sound;
  edited.models.at("note").cases.at(case_name).at("C_D").u = 1e9;
  CHECK_THAT(refused_as(edited), Contains(case_name + " C_D u 1e+09 in the baseline"));
  edited.models.at("note").cases.at(case_name).at("C_D").u = 1.00001 * entries.at(case_name).at("C_D").u;
  CHECK_THAT(refused_as(edited), Contains(case_name + " C_D u"));
  edited = sound;
  edited.case_budget = 1e9;
  CHECK_THAT(refused_as(edited), Contains("a case: budget 1e+09, above 0 and at most 0.01 needed"));
  for (const double budget : {1e9, 0.0051, 0.0, -0.005}) {
    edited = sound;
    edited.models.at("note").groups.at(family).at("C_D").budget = budget;
    CHECK_THAT(refused_as(edited), Contains(family + " C_D budget") && Contains("at most 0.005"));
  }
  edited = sound;
  edited.models.at("note").groups.at(family).at("C_D").rms = 1e9;
  CHECK_THAT(refused_as(edited), Contains(family + " C_D rms error 1e+09 in the baseline"));
  edited.models.at("note").groups.at(family).erase("C_D");
  CHECK_THAT(refused_as(edited), Contains(family + " C_D has no rms error"));
  // A smaller budget is a stricter gate.
  edited = sound;
  edited.case_budget = 0.002;
  edited.models.at("note").groups.at(family).at("C_D").budget = 0.001;
  CHECK(compare::run_gate(edited, records).passed());
}

TEST_CASE("accepting keeps a stricter budget and puts a wider one right, and the difference shows it", "[compare][gate][regression]") {
  const auto records = sample::quick_tier();
  auto previous = compare::make_baseline(records, "test");
  auto& group = previous.models.at("note").groups.begin()->second.at("C_D");
  previous.case_budget = 1e9;
  group.budget = 0.001;
  const auto next = compare::make_baseline(records, "again", previous);
  CHECK(next.case_budget == compare::standing_case_budget);
  CHECK(next.models.at("note").groups.begin()->second.at("C_D").budget == 0.001);
  CHECK(compare::run_gate(next, records).passed());
  REQUIRE(compare::differences(previous, next).size() == 1);
  CHECK_THAT(compare::differences(previous, next)[0], Contains("budget of a case: 1e+09 -> 0.01"));
}

TEST_CASE("a dropped or diverged case leaves the comparison incomplete", "[compare][gate][regression]") {
  const auto records = sample::quick_tier();
  const auto baseline = compare::make_baseline(records, "test");
  auto dropped = records;
  dropped.erase(dropped.begin() + 4);
  auto result = compare::run_gate(baseline, dropped);
  CHECK_FALSE(result.complete());
  CHECK_FALSE(result.passed());
  CHECK(result.compared == 11);
  CHECK_THAT(compare::render(result), Contains(records[4].name) && Contains("11 of 12"));
  auto diverged = records;
  diverged[4].status = case_record::Status::diverged;
  CHECK_FALSE(compare::run_gate(baseline, diverged).complete());
  CHECK_FALSE(compare::run_gate(baseline, {}).complete());
}

TEST_CASE("a reference that leans where symmetry forbids it turns the gate red", "[compare][gate][regression]") {
  auto records = sample::quick_tier();
  records[1].load.force_pressure.y() += 0.1 * compare::coefficient_scales(records[1])[0];  // a side force on a plate at incidence
  // Even a baseline that accepted it does not make it right.
  const auto result = compare::run_gate(compare::make_baseline(records, "test"), records);
  CHECK_THAT(failures(result), Contains("null channels"));
}

TEST_CASE("cases solved again agree within their uncertainty, or the gate says by how much they do not", "[compare][gate][regression]") {
  const auto records = sample::quick_tier();
  CHECK(compare::check_solved_again({}, records, {records[0], records[4]}).passed);
  auto again = records[4];
  again.load.force_pressure.x() *= 1.05;  // its uncertainty is far below 5 %
  const auto check = compare::check_solved_again({}, records, {again});
  CHECK_FALSE(check.passed);
  CHECK_THAT(check.detail, Contains(again.name + " C_D"));
  again = records[4];
  again.status = case_record::Status::diverged;
  CHECK_FALSE(compare::check_solved_again({}, records, {again}).passed);
  again = records[4];
  again.name = "another_medium";
  CHECK_FALSE(compare::check_solved_again({}, records, {again}).passed);
  CHECK_FALSE(compare::check_solved_again({}, records, {}).passed);  // nothing to look at
}

TEST_CASE("a baseline comes back from its file, with all reasons", "[compare][gate][invariance]") {
  const sample::Folder folder;
  const auto records = sample::quick_tier();
  const auto first = compare::make_baseline(records, "first of all");
  const auto second = compare::make_baseline(records, "again", first);
  compare::write_baseline(folder / "deep/quick.json", second);
  const auto back = compare::read_baseline(folder / "deep/quick.json");
  CHECK(compare::differences(second, back).empty());
  CHECK(compare::run_gate(back, records).passed());
  REQUIRE(back.history.size() == 2);
  CHECK(back.history[0].reason == "first of all");
  CHECK(back.history[1].reason == "again");
}

TEST_CASE("differences between baselines name case, channel and both numbers", "[compare][gate][analytic]") {
  const auto records = sample::quick_tier();
  auto changed = records;
  changed[0].load.force_pressure.x() *= 1.1;
  changed.pop_back();
  const auto lines = compare::differences(compare::make_baseline(records, "a"), compare::make_baseline(changed, "b"));
  std::string text;
  for (const auto& line : lines) text += line + "\n";
  CHECK_THAT(text, Contains("- case " + records.back().name));
  CHECK_THAT(text, Contains(records[0].name + " C_D: CFD"));
  auto without_channel = compare::make_baseline(records, "b");
  without_channel.models.at("note").cases.at(records[0].name).erase("C_m");
  CHECK(compare::differences(compare::make_baseline(records, "a"), without_channel) ==
        std::vector<std::string>{"- note " + records[0].name + " C_m"});
}

TEST_CASE("a missing or broken baseline is an error that says what to do, and nothing is created", "[compare][gate][hard]") {
  const sample::Folder folder;
  CHECK_THROWS_WITH(compare::read_baseline(folder / "none.json"), Contains("none.json") && Contains("dragval baseline accept"));
  CHECK_FALSE(std::filesystem::exists(folder / "none.json"));
  std::ofstream(folder / "broken.json") << "{\"schema\": \"dragval baseline 1\", ";
  CHECK_THROWS_WITH(compare::read_baseline(folder / "broken.json"), Contains("broken.json"));
  std::ofstream(folder / "newer.json") << "{\"schema\": \"dragval baseline 7\"}";
  CHECK_THROWS_WITH(compare::read_baseline(folder / "newer.json"), Contains("dragval baseline 7"));
  CHECK_THROWS_WITH(compare::make_baseline(sample::quick_tier(), ""), Contains("reason"));
  CHECK_THROWS_WITH(compare::make_baseline({}, "empty"), Contains("no usable case"));
}

TEST_CASE("every seeded defect that changes a coefficient turns the gate red, and unchanged code passes", "[compare][gate][regression]") {
  const auto records = sample::quick_tier();
  const compare::Odds odds = compare::gate_odds(compare::make_baseline(records, "test"), records, {});
  CHECK(odds.unchanged_passes);
  CHECK(odds.defects.size() >= 40);
  int effective = 0;
  for (const compare::DefectVerdict& verdict : odds.defects) {
    INFO(verdict.where << ": " << verdict.name << ", " << verdict.coefficients << " coefficients");
    // The samples have no concave body and no half model: what changes nothing there must not be called caught.
    CHECK(verdict.caught == (verdict.coefficients > 0 || verdict.where == "baseline"));
    effective += verdict.caught;
  }
  CHECK(effective >= 30);
}

TEST_CASE("solved again on meshes of other seeds: five standard deviations of a difference are allowed, a budget below it is refused",
          "[compare][gate][analytic]") {
  auto records = sample::quick_tier();
  CaseRecord& cube = records[4];
  cube.u_iteration.setZero(), cube.u_statistical.setZero();
  const double q_area = compare::coefficient_scales(cube)[0], drag = cube.load.force().x() / q_area;
  const auto with_seed = [&](int seed, double drag_change) {
    CaseRecord run = cube;
    run.name += "_seed-" + std::to_string(seed);
    run.load.force_pressure.x() += drag_change * q_area;
    return run;
  };
  // Six seeds above the judged ones, C_D off by -0.02 and +0.02 in turn: a standard deviation of 0.02 sqrt(6/5).
  std::vector<CaseRecord> solved;
  for (int i = 0; i < 6; ++i) solved.push_back(with_seed(compare::judged_seeds + 1 + i, i % 2 ? 0.02 : -0.02));
  compare::Baseline baseline = compare::make_baseline(records, "test");
  baseline.seed_scatter = compare::scatter_over_seeds(solved);
  const double scatter = 0.02 * std::sqrt(1.2), allowed = 5.0 * std::sqrt(2.0) * scatter;
  REQUIRE(baseline.seed_scatter.at(cube.name)[0] == Approx(scatter));
  solved.resize(4);
  CHECK(compare::scatter_over_seeds(solved).empty());               // too few to say
  CHECK(compare::scatter_over_seeds({with_seed(1, 0.1)}).empty());  // a judged one
  CHECK(compare::check_solved_again(baseline, records, {with_seed(1, 0.99 * allowed)}).passed);
  CHECK_FALSE(compare::check_solved_again(baseline, records, {with_seed(1, 1.01 * allowed)}).passed);
  CHECK_FALSE(compare::check_solved_again({}, records, {with_seed(1, 0.99 * allowed)}).passed);  // a baseline that knows no scatter
  const double needed = allowed / drag;
  CHECK(compare::check_solved_again(baseline, records, {with_seed(1, 0.99 * allowed)}, 1.01 * needed).passed);
  CHECK_THROWS_WITH(compare::check_solved_again(baseline, records, {with_seed(1, 0.0)}, 0.99 * needed),
                    Contains("--solved-budget") && Contains(cube.name) && Contains("unchanged code fails"));
  // Judged one by one, and those that say the scatter are not.
  const auto odds = compare::gate_odds(baseline, records, {with_seed(1, 0.0), with_seed(2, 1.2 * allowed), with_seed(101, 2.0 * allowed)});
  CHECK(odds.repeats == 2);
  REQUIRE(odds.false_alarms.size() == 1);
  CHECK_THAT(odds.false_alarms[0], Contains("seed-2 C_D"));
  CHECK_THROWS_WITH(compare::gate_odds({}, records, {}), Contains("without planned cases"));
  CHECK(compare::seeded_name("cube_seed-7").seed == 7);
  CHECK(compare::seeded_name("cube_seed-7b").seed == 0);
  CHECK(compare::seeded_name("cube_seed-").base == "cube_seed-");
}

TEST_CASE("a review counts what gets better and worse, in u, and names the largest changes", "[compare][gate][analytic]") {
  const auto records = sample::quick_tier();
  auto better = records;
  const double before = compare::make_baseline(records, "a").models.at("note").cases.at(records[0].name).at("C_D").model.value();
  const double q_area = compare::coefficient_scales(records[0])[0];
  better[0].load.force_pressure.x() = before * q_area - better[0].load.force_viscous.x();  // now the note is right about this one
  better.pop_back();
  const auto first = compare::make_baseline(records, "a"), second = compare::make_baseline(better, "b");
  const compare::BaselineReview review = compare::review(first, second);
  CHECK(review.cases_added == 0);
  CHECK(review.cases_removed == 1);
  CHECK(review.references_changed >= 1);
  const auto group =
      std::find_if(review.groups.begin(), review.groups.end(), [](const auto& g) { return g.model == "note" && g.channel == "C_D"; });
  REQUIRE(group != review.groups.end());
  CHECK(group->better == 1);
  CHECK(group->better_by_2u == 1);
  CHECK(group->worse == 0);
  CHECK(group->rms_after < group->rms_before);
  const auto change = std::find_if(review.largest.begin(), review.largest.end(), [&](const auto& c) {
    return c.model == "note" && c.case_name == records[0].name && c.channel == "C_D";
  });
  REQUIRE(change != review.largest.end());
  CHECK(change->error_after == Approx(0.0).margin(1e-12));
  CHECK(change->growth_in_u() < -2.0);
  CHECK_THAT(compare::render(review, compare::Format::table), Contains("1 removed") && Contains(records[0].name));
  CHECK_THAT(compare::render(compare::review(first, first), compare::Format::markdown), Contains("no error"));
  CHECK_THROWS_WITH(compare::render(review, compare::Format::csv), Contains("json"));
}

TEST_CASE("a gate's result for pull requests, CI servers and GitHub: every check, special characters escaped",
          "[compare][gate][analytic]") {
  compare::GateResult result;
  result.planned = result.compared = 1;
  result.checks = {{"note: signs", true, 3, "nearest <a> & \"b\""}, {"note: 5 % off, of it", false, 2, "x | y\n100 %"}};
  using compare::GateFormat;
  const std::string junit = compare::render(result, GateFormat::junit);
  CHECK_THAT(junit, Contains("tests=\"2\" failures=\"1\"") && Contains("nearest &lt;a&gt; &amp; &quot;b&quot;") && Contains("<failure"));
  const std::string github = compare::render(result, GateFormat::github);
  CHECK_THAT(github, Contains("::error title=note%3A 5 %25 off%2C of it::x | y%0A100 %25") && Contains("gate failed: 1 of 2"));
  CHECK_THAT(github, !Contains("signs"));
  CHECK_THAT(compare::render(result, GateFormat::markdown), Contains("x \\| y") && Contains("1 checks passed"));
  CHECK(compare::gate_format_from("junit") == GateFormat::junit);
  CHECK_THROWS_WITH(compare::gate_format_from("xml"), Contains("junit"));
}
