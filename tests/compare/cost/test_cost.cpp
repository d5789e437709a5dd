#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/calibration/prediction.hpp"
#include "compare/cost/answers.hpp"
#include "compare/cost/cfd_cost.hpp"
#include "tests/compare/sample_records.hpp"

using namespace compare;
using case_record::CaseRecord;
using Catch::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

Rung rung(const std::string& name, const std::string& kind, double seconds, double error) {
  return {name, kind, kind == "law" ? 12.0 : 0.0, seconds, {error, error, error, error}, 10};
}

/// Five rungs whose front, halvings and targets can be seen by eye.
Ladder sample_ladder() {
  Ladder ladder{.poses = 10, .bodies = 2};
  ladder.uncertainty.relative = 0.03;
  ladder.rungs = {rung("medium", "CFD", 100.0, 0.02), rung("slow", "law", 1e-4, 0.3), rung("constant", "constant", 1e-9, 0.8),
                  rung("note", "law", 1e-7, 0.4), rung("fine law", "law", 1e-6, 0.1)};
  return ladder;
}

/// A campaign that a drag model made: what it says of itself must be exact.
std::vector<CaseRecord> campaign(const ModelChoice& truth) {
  std::vector<CaseRecord> records = sample::quick_tier();
  for (CaseRecord& record : records) {
    record.viscosity = 0.0;  // as the ladder has it: baked maps know none
    const dragcore::Wrench wrench = predict(record, truth).total();
    record.load = {};
    record.load.force_pressure = wrench.force;
    record.load.moment_pressure = wrench.torque;
  }
  return records;
}

}  // namespace

TEST_CASE("the front holds what nothing cheaper is as near as, and the price of half an error follows from it", "[compare][cost]") {
  const Ladder ladder = sample_ladder();
  const auto front = pareto_front(ladder.rungs);
  std::vector<std::string> names;
  for (const Rung* each : front) names.push_back(each->name);
  CHECK(names == std::vector<std::string>{"constant", "note", "fine law", "medium"});  // "slow" is dearer and further off than "fine law"

  const auto steps = front_steps(front);
  REQUIRE(steps.size() == 3);
  CHECK_THAT(steps[0].times_cost, WithinRel(100.0, 1e-12));
  CHECK_THAT(steps[0].halving_cost, WithinRel(100.0, 1e-12));  // 0.8 to 0.4 is one halving
  CHECK_THAT(steps[1].times_cost, WithinRel(10.0, 1e-12));
  CHECK_THAT(steps[1].halving_cost, WithinRel(std::sqrt(10.0), 1e-12));  // 0.4 to 0.1 is two

  const auto halves = halvings(front);
  REQUIRE(halves.size() == 3);
  CHECK(halves[1].from == front[1]);
  CHECK(halves[1].to == front[2]);
  CHECK_THAT(halves[2].times_cost, WithinRel(1e8, 1e-12));

  std::vector<Rung> nearly = {rung("a", "law", 1.0, 0.100), rung("b", "law", 2.0, 0.099)};
  CHECK(pareto_front(nearly).size() == 1);  // one in a hundred nearer is no reason to pay twice
  CHECK(front_steps({}).empty());
  CHECK(halvings({}).empty());
}

TEST_CASE("a wanted error is reached by the cheapest, or by nothing, and the references say whether that can be told", "[compare][cost]") {
  const Ladder ladder = sample_ladder();
  const TargetAnswer easy = reach(ladder, 0.1);
  REQUIRE(easy.law);
  REQUIRE(easy.cfd);
  CHECK(easy.law->name == "fine law");
  CHECK(easy.cfd->name == "medium");
  CHECK_THAT(answer(ladder, easy),
             Contains("reached by a law and by CFD") && Contains("'fine law' on 12 triangles, 10.0 % for 1.0 \u00b5s") &&
                 Contains("OpenFOAM, medium, 2.0 % for 1.7 min") && Contains("known to 3.0 %") && !Contains("cannot be told"));
  const TargetAnswer hard = reach(ladder, 0.02);
  CHECK(!hard.law);
  REQUIRE(hard.best_law);
  CHECK(hard.best_law->name == "fine law");
  CHECK_THAT(answer(ladder, hard), Contains("CFD alone") && Contains("not reached; nearest is 'fine law'") && Contains("cannot be told"));
  const TargetAnswer beyond = reach(ladder, 0.001);
  CHECK((!beyond.law && !beyond.cfd));
  CHECK_THAT(answer(ladder, beyond), Contains("nothing that was measured reaches it"));
  CHECK(to_json(beyond)["cheapest_cfd"].is_null());
  CHECK(to_json(beyond)["nearest_cfd"]["name"] == "medium");
}

TEST_CASE("the first lines say which rung is nearest, and what half the error costs", "[compare][cost]") {
  const std::string text = answer(sample_ladder());
  CHECK_THAT(text.substr(0, text.find('\n')), Contains("'fine law' on 12 triangles, 10.0 % for 1.0 \u00b5s"));
  CHECK_THAT(text, Contains("Half the error of 'constant' costs \u00d7 100: from 80.0 % for 1.0 ns to 'note'"));
  CHECK_THAT(text, Contains("Half of the 2.0 % of OpenFOAM, medium is reached by nothing"));
}

TEST_CASE("times are read by people", "[compare][cost]") {
  CHECK(time_text(1.44e-9) == "1.4 ns");
  CHECK(time_text(23.4e-6) == "23 \u00b5s");
  CHECK(time_text(0.99999e-3) == "1.0 ms");
  CHECK(time_text(59.0) == "59 s");
  CHECK(time_text(4500.0) == "1.2 h");
  CHECK(times_text(3.16) == "\u00d7 3.2");
  CHECK(times_text(485.2) == "\u00d7 485");
  CHECK(times_text(1.2e7) == "\u00d7 1e7");
  CHECK(times_text(9.7e6) == "\u00d7 1e7");
}

TEST_CASE("the law that made the references has no error, on its own mesh and in double, and every other rung has one", "[compare][cost]") {
  const std::vector<CaseRecord> records = campaign(ModelChoice::recommended());
  const Ladder ladder = measure_ladder(records, {.quick = true});
  CHECK(ladder.poses == 12);
  CHECK(ladder.bodies == 3);
  const Rung* best = ladder.rung("class, pillow, in double");
  REQUIRE(best);
  CHECK(best->errors.relative < 1e-12);  // rounding
  CHECK(best->errors.torque < 1e-12);
  REQUIRE(ladder.rung(best_law));
  CHECK(ladder.rung(best_law)->errors.relative < 2e-5);  // single precision: 1e-5 of the force of sheets edge-on
  for (const char* other : {"one C_D for all", "C_D of the body", "Jolt's formula", "note", "consistent"}) {
    INFO(other);
    REQUIRE(ladder.rung(other));
    CHECK(ladder.rung(other)->errors.relative > 0.05);
    CHECK(ladder.rung(other)->seconds > 0.0);
  }
  // Without the pillow the force is the same, and the torque is not.
  CHECK(ladder.rung("class")->errors.relative < 2e-5);
  CHECK(ladder.rung("class")->errors.torque > 0.01);
  for (const Ablation& row : ladder.ablation)
    if (row.effect == "base suction") CHECK(row.errors.drag > 0.1);  // 0.36 of the closed law, on two bodies of three
  CHECK(ladder.meshes.size() == 15);                                 // three bodies, 1 to 16 segments
  CHECK(ladder.meshes.back().force_ratio == 1.0);
  CHECK(ladder.spin.empty());  // nothing spins here
  for (const CostTable& table : cost_tables(ladder)) CHECK(table.grid.rows.size() > 1);
  CHECK(all_rungs(ladder).grid.rows.size() == ladder.rungs.size() + 1);
  CHECK(to_json(ladder)["rungs"].size() == ladder.rungs.size());
}

TEST_CASE("a coarse mesh of CFD is as wrong as it is far from the finest, and costs what it took", "[compare][cost]") {
  std::vector<CaseRecord> records = campaign(ModelChoice::recommended());
  CaseRecord& cube = records[4];
  REQUIRE(cube.name == "cube_yaw-000_re-1e5_medium");
  cube.u_iteration.setZero();
  cube.u_statistical.setZero();
  CaseRecord coarse = cube;
  coarse.name = "cube_yaw-000_re-1e5_coarse";
  coarse.mesh_level = "coarse";
  coarse.cells = 4000;
  coarse.cost = {{"solve", {5.0, 5.0}}};
  const double scale = coefficient_scales(cube)[0];
  coarse.load.force_pressure.x() += 0.1 * scale;
  records.push_back(coarse);
  const Ladder ladder = measure_ladder(records, {.body = "cube", .quick = true});
  CHECK(ladder.poses == 4);
  const Rung* found = ladder.rung("k_omega_sst, coarse");
  REQUIRE(found);
  CHECK(found->kind == "CFD");
  CHECK(found->poses == 1);
  CHECK_THAT(found->seconds, WithinAbs(5.0, 1e-12));
  // Two meshes: u of the finer is 3/2 of the difference over r^2 - 1, r the ratio of cell sizes (docs/conventions.md, "Uncertainty").
  const double u = 1.5 * 0.1 / (std::pow(3.0, 2.0 / 3.0) - 1.0);
  CHECK_THAT(found->errors.drag, WithinRel(std::hypot(0.1, u), 1e-9));
  CHECK_THROWS_WITH(measure_ladder(records, {.body = "wing", .quick = true}), Contains("'wing'") && Contains("cone, cube, plate"));
}

TEST_CASE("every usable case of CFD has its CPU time, and the finest mesh its name", "[compare][cost]") {
  std::vector<CaseRecord> records = sample::quick_tier();
  CaseRecord fine = records[4];
  fine.mesh_level = "fine";
  fine.name.replace(fine.name.find("medium"), 6, "fine");
  fine.cells *= 3;
  fine.load.force_pressure.x() += 0.05 * coefficient_scales(fine)[0];
  fine.cost["solve"] = {40.0, 41.0};
  records.push_back(fine);
  records[0].status = case_record::Status::diverged;
  const std::vector<CfdCost> rows = cfd_costs(records);
  CHECK(rows.size() == 12);  // 12 poses, a finer mesh, less the one that diverged
  for (const CfdCost& row : rows) {
    if (row.drag_error) CHECK_THAT(*row.drag_error, WithinAbs(0.05, 1e-12));
    if (row.finest) CHECK_THAT(row.total_s, WithinAbs(42.5, 1e-12));  // 2.5 s of meshing
  }
}

TEST_CASE("bodies that spin tell the orders of quadrature apart: six points are their own measure, one is furthest off",
          "[compare][cost]") {
  ModelChoice six = ModelChoice::recommended();
  six.model.quadrature = dragcore::Quadrature::six;
  std::vector<CaseRecord> spinning = {sample::spinning("cube_spin-z", dragcore::Box{}, {0, 0, 1}, 0.0, 1e5),
                                      sample::spinning("plate_spin-y", dragcore::Plate{}, {0, 1, 0}, 0.0, 1e5)};
  for (CaseRecord& record : spinning) record.load.moment_pressure = predict(record, six).total().torque;
  CaseRecord slow = spinning.front();
  slow.reynolds = 100.0;  // laminar friction is no business of these laws
  spinning.push_back(slow);
  const Ladder ladder = measure_ladder(campaign(six), {.spinning = spinning, .quick = true});
  REQUIRE(ladder.spin.size() == 4);
  const SpinStep &one = ladder.spin[0], &three = ladder.spin[1], &all = ladder.spin[2], &adaptive = ladder.spin[3];
  CHECK(all.cases == 2);
  CHECK(all.rule_error == 0.0);
  CHECK(all.cfd_error < 1e-12);  // rounding: the references were made so
  CHECK(one.rule_error > 0.02);
  CHECK(three.rule_error < 0.2 * one.rule_error);
  CHECK(adaptive.rule_error < 0.2 * one.rule_error);
}

TEST_CASE("what an early stop leaves and saves is read off the drift of the references and off a study", "[compare][cost]") {
  std::vector<CaseRecord> records = campaign(ModelChoice::recommended());
  for (CaseRecord& record : records) {
    record.u_iteration.setZero();
    record.u_iteration[0] = 0.01 * record.load.force().norm();
  }
  CaseRecord longer = records[4];
  longer.name += "_iterations-800";
  longer.load.force_pressure.x() *= 1.002;
  longer.cost = {{"solve", {46.5, 46.5}}};  // the usual: 2.5 of meshing and 13.0 of solving
  const Ladder ladder = measure_ladder(records, {.studies = {records[4], longer}, .quick = true});
  CHECK(ladder.stopping.poses == 12);
  CHECK_THAT(ladder.stopping.left, WithinRel(0.01, 1e-9));
  REQUIRE(ladder.stopping.longer_cost_high);
  CHECK_THAT(*ladder.stopping.longer_cost_high, WithinRel(3.0, 1e-9));
  CHECK_THAT(ladder.stopping.longer_change, WithinRel(0.002, 1e-6));
  CHECK_THAT(cost_tables(ladder).front().note, Contains("drift of 1.0 %") && Contains("3.0 to 3.0 times as much"));
}
