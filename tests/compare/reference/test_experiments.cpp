#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

#include "compare/calibration/calibration.hpp"
#include "compare/cost/cfd_cost.hpp"
#include "compare/reference/case_of_record.hpp"
#include "compare/reference/experiments.hpp"
#include "compare/reference/published.hpp"
#include "compare/store/store.hpp"
#include "compare/tables/error_table.hpp"
#include "compare/tables/mesh_table.hpp"
#include "tests/compare/sample_records.hpp"

using case_record::CaseRecord;
using Catch::Contains;
using compare::Channel;

namespace {

const std::string heading = "shape,parameters,incidence_deg,reynolds,area_m2,C_D,u_C_D,held_out,source\n";
const std::string ball_line = "sphere,diameter=1,0,1e5,0.7853981633974483,0.5,0.02,0,somebody_1900\n";
const std::string plate_line = "plate,,30,1e5,1,0.55,0.01,0,somebody_1900\n";

CaseRecord read_one(const std::string& line) {
  auto records = compare::read_experiments(heading + line, "table.csv");
  REQUIRE(records.size() == 1);
  records.front().name = "measured";
  return records.front();
}

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  REQUIRE(file);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_CASE("a measured drag stands on the reference area of its body, and symmetry says the rest", "[compare][experiments][analytic]") {
  const CaseRecord ball = read_one(ball_line);
  CHECK(ball.is_experiment());
  CHECK(ball.viscosity == Approx(1e-5));  // 1 m/s, 1 m, Re 1e5
  const auto c = compare::coefficients(ball);
  CHECK(*c[Channel::drag] == Approx(0.5));
  for (const Channel channel : {Channel::side, Channel::lift, Channel::roll, Channel::pitch, Channel::yaw}) CHECK(c[channel] == 0.0);
  CHECK(ball.u_stated[0] / compare::coefficient_scales(ball)[0] == Approx(0.02));
  CHECK(ball.u_stated.tail<5>().isZero());

  // Broadside, published on length times diameter: 0.68 on 2 m^2 is 0.68 * 2 / (pi / 4) on A_ref.
  const CaseRecord broadside = read_one("cylinder,diameter=1 length=2,90,1e5,2,0.68,0.05,1,somebody_1900\n");
  CHECK(*compare::coefficients(broadside)[Channel::drag] == Approx(0.68 * 8 / std::numbers::pi));
  CHECK(*compare::coefficients(broadside)[Channel::lift] == 0.0);
  CHECK(broadside.held_out);
}

TEST_CASE("lift and moment are taken where they are given, on their own length", "[compare][experiments][analytic]") {
  const auto records = compare::read_experiments(
      "shape,parameters,incidence_deg,reynolds,area_m2,length_m,C_D,u_C_D,C_L,u_C_L,C_m,u_C_m,source,remark\n"
      "plate,chord=2 span=1,30,1e5,2,4,0.5,0.01,0.8,0.02,0.05,0.01,me,\"with a comma, and \"\"quotes\"\"\"\n",
      "table.csv");
  const auto c = compare::coefficients(records.front());
  CHECK(*c[Channel::lift] == Approx(0.8));
  CHECK(*c[Channel::pitch] == Approx(0.1));  // 0.05 over 4 m is 0.1 over the chord of 2 m
  CHECK(c.centre_of_pressure);
  CHECK_THAT(records.front().description, Contains(R"(with a comma, and \"quotes\")"));
}

TEST_CASE("what nobody measured is unknown, not zero", "[compare][experiments][limit]") {
  const CaseRecord plate = read_one(plate_line);
  const auto c = compare::coefficients(plate);
  CHECK(c[Channel::drag]);
  CHECK(c[Channel::side] == 0.0);  // a mirror plane holds the wind
  CHECK_FALSE(c[Channel::lift]);
  CHECK_FALSE(c[Channel::pitch]);
  CHECK_FALSE(c[Channel::centre_of_pressure]);
  const auto table = compare::compare_with({plate}, compare::predictor({}), "note");
  for (const auto& row : table.rows) {
    CHECK(row.error.has_value() == (row.channel == Channel::drag));
    if (row.channel == Channel::lift) CHECK(row.reason == "not measured");
  }
  CHECK(table.doubts.large + table.doubts.small == 0);  // of the force vector, which is not known
  CHECK_THAT(compare::render(table, compare::Format::table), Contains("experiment") && Contains("not measured"));

  // Its drag is fitted to, its line of action is not.
  std::vector<CaseRecord> records = sample::quick_tier();
  records.push_back(plate);
  records.back().pose.incidence = 20 * sample::deg;  // a pose that nobody solved
  const compare::Calibration found = compare::calibrate(records);
  CHECK(found.fits.front().cases.size() == 13);
  CHECK(found.fit("pillow tilt on law note").cases.size() == 12);
}

TEST_CASE("an experiment stands for a pose where its force is known better, and the solution stays on record", "[compare][experiments]") {
  CaseRecord solved = sample::record("sphere_incidence-000_re-1e5", dragcore::Sphere{}, {});
  solved.held_out = true;
  const std::vector records = {solved, read_one(ball_line)};
  const auto cases = compare::cases_of_record(records);
  REQUIRE(cases.size() == 1);
  CHECK(cases[0].family.record->is_experiment());  // 4 % against the 45 % of steady RANS
  CHECK(cases[0].held_out);                        // what a lot has held out no experiment brings back
  REQUIRE(cases[0].alternatives.size() == 1);
  CHECK(cases[0].alternatives[0].record->name == solved.name);
  CHECK_THAT(cases[0].note, Contains("measured: C_D 0.500") && Contains("not sphere_incidence-000_re-1e5_medium"));
  CHECK(cases[0].family.uncertainty.total[0] / compare::coefficient_scales(*cases[0].family.record)[0] == Approx(0.02));

  // The check of the CFD still looks at the CFD, and never at the experiment.
  const auto checks = compare::published_checks(cases);
  REQUIRE(checks.size() == 1);
  CHECK(checks[0].case_name == solved.name);
  CHECK_FALSE(checks[0].of_record);

  const auto table = compare::compare_with(records, compare::predictor({}), "note");
  CHECK(table.compared == 1);
  CHECK(table.rows.front().family == "sphere, Re 100000, k_omega_sst");
  CHECK(table.rows.front().discretisation_assessed);  // u lacks nothing
  CHECK(table.totals.front().group == "turbulent, held out");

  // Neither mesh nor cost.
  CHECK(compare::mesh_rows(records).front().poses == 1);
  CHECK(compare::cfd_costs(records).size() == 1);
}

TEST_CASE("an experiment known worse, or in part, does not stand for what was solved", "[compare][experiments][limit]") {
  const auto solved = sample::record("plate_incidence-030_re-1e5", dragcore::Plate{}, {.incidence = 30 * sample::deg});
  const auto record_of = [](const std::vector<CaseRecord>& records) {
    const auto cases = compare::cases_of_record(records);
    REQUIRE(cases.size() == 1);
    return cases[0].family.record->name;
  };
  CHECK(record_of({solved, read_one(plate_line)}) == solved.name);  // 2 % of the drag, nothing of the lift
  const auto ball_on = [](const std::string& level, int cells) {
    return sample::record("sphere_incidence-000_re-1e5", dragcore::Sphere{}, {}, level, cells);
  };
  const auto ball = ball_on("fine", 96000);
  const auto known_worse = read_one("sphere,,0,1e5,0.785,0.5,0.3,0,somebody_1900\n");
  CHECK(record_of({ball_on("medium", 12000), ball, known_worse}) == ball.name);
  CHECK(record_of({ball, known_worse}) == known_worse.name);  // on one mesh nobody knows what the mesh does
  CHECK(compare::cases_of_record({ball, read_one("sphere,,0,1e4,0.785,0.5,0.02,0,somebody_1900\n")}).size() == 2);
}

TEST_CASE("a table that cannot be right is refused with its line and what is needed", "[compare][experiments][hard]") {
  const auto read = [](const std::string& text) { return compare::read_experiments(text, "table.csv"); };
  const auto refused = [&](const std::string& text, const std::string& word) {
    try {
      read(text);
      FAIL("accepted: " + text);
    } catch (const std::invalid_argument& fault) {
      CHECK_THAT(fault.what(), Contains("table.csv") && Contains(word));
    }
  };
  refused("", "no measurement");
  refused("shape,colour\n", "colour");
  refused(heading + "sphere,,0,1e5,1,0.5,0.02,0\n", "8 cells, the heading has 9");
  refused(heading + "ball,,0,1e5,1,0.5,0.02,0,me\n", "line 2");
  refused(heading + "sphere,diameter,0,1e5,1,0.5,0.02,0,me\n", "name=number");
  refused(heading + "sphere,diameter=-1,0,1e5,1,0.5,0.02,0,me\n", "-1");
  refused(heading + "sphere,,0,1e5,,0.5,0.02,0,me\n", "area of the coefficients");
  refused(heading + "sphere,,0,0,1,0.5,0.02,0,me\n", "above 0");
  refused(heading + "sphere,,0,1e5,1,half,0.02,0,me\n", "'half'");
  refused(heading + "sphere,,0,1e5,1,0.5,,0,me\n", "u_C_D go together");
  refused(heading + "sphere,,0,1e5,1,0.5,0,0,me\n", "above 0");
  refused(heading + "sphere,,0,1e5,1,nan,0.02,0,me\n", "'nan'");
  refused(heading + "sphere,,0,1e5,1,,,0,me\n", "no coefficient");
  refused(heading + "sphere,,0,1e5,1,0.5,0.02,0,\n", "source is empty");
}

TEST_CASE("the committed experiments name their sources, and hold out whatever body the campaign holds out", "[compare][experiments]") {
  const std::string folder = SOURCE_FOLDER;
  const auto experiments = compare::read_experiments(text_of(folder + "/compare/reference/experiments.csv"), "experiments.csv");
  const std::string references = text_of(folder + "/references.bib");
  std::map<std::pair<std::string, std::map<std::string, double>>, bool> held_out;
  for (const CaseRecord& record : compare::read_reference(folder + "/results/reference.h5").cases)
    if (!record.is_experiment() && !record.spins() && record.flow_model == "k_omega_sst")
      held_out[{dragcore::kind(record.shape), dragcore::parameters(record.shape)}] |= record.held_out;
  for (const CaseRecord& record : experiments) {
    CAPTURE(record.description);
    CHECK_THAT(references, Contains("{" + record.source + ","));
    const auto body = held_out.find({dragcore::kind(record.shape), dragcore::parameters(record.shape)});
    if (body != held_out.end()) CHECK(record.held_out == body->second);
    if (record.description.find("from memory") != std::string::npos) CHECK(record.held_out);
  }
}
