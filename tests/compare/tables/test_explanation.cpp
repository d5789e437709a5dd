#include <catch2/catch.hpp>

#include "compare/gate/baseline.hpp"
#include "compare/tables/explanation.hpp"
#include "tests/compare/sample_records.hpp"

using Catch::Contains;
using sample::CaseRecord;

namespace {

compare::NamedModel recommended() { return {"by class", compare::ModelChoice::recommended()}; }

std::vector<compare::Explanation> asked(const std::vector<CaseRecord>& records, const std::string& body, const std::string& pose) {
  return compare::explain_error(compare::merged({}, records), recommended(), compare::gated_models(),
                                compare::pose_question(body, pose, 1e5));
}

}  // namespace

TEST_CASE("an explanation has the numbers of the error table, and its terms add up to the model", "[compare][explanation][analytic]") {
  const auto records = sample::quick_tier();
  const auto found = asked(records, "cube", "yaw 45");
  REQUIRE(found.size() == 1);
  const compare::Explanation& e = found[0];
  CHECK(e.case_name == "cube_yaw-045_re-1e5_medium");
  CHECK(e.title == "cube, yaw 45\u00b0, Re 100000");
  const auto table = compare::compare_with(records, compare::predictor(recommended().choice), "by class");
  for (const compare::ErrorRow& row : table.rows)
    if (row.case_name == e.case_name && row.channel == compare::Channel::drag) {
      CHECK(e.model == Approx(row.model.value()));
      CHECK(e.reference == Approx(row.cfd.value()));
      CHECK(e.u == Approx(row.u));
      CHECK(e.resolved() == (row.verdict == compare::Verdict::resolved));
    }
  double sum = 0.0;
  for (const auto& [name, drag] : e.terms) sum += drag;
  CHECK(sum == Approx(e.model).epsilon(0.06));  // those below a hundredth of it, at most six, are not listed
  // A side force that the model does not have is told beside a C_D that is right.
  auto leaning = records;
  for (CaseRecord& record : leaning)
    if (record.name == e.case_name) record.load.force_pressure.y() += 0.3 * compare::coefficient_scales(record)[0];
  const auto also = asked(leaning, "cube", "yaw 45")[0].also;
  CHECK(std::any_of(also.begin(), also.end(), [](const auto& channel) { return channel.symbol == "C_S" && std::abs(channel.error) > 0.2; }));
  REQUIRE(e.law);
  CHECK_THAT(compare::render(e),
             Contains("model:") && Contains("reference:") && Contains("error:") && Contains("made of:") && Contains("half of it:"));
}

TEST_CASE("the patch that is named is the one whose pressure was spoilt, whatever the gauge of the model",
          "[compare][explanation][analytic]") {
  // Pressures of the model itself, by patch, then one face pushed by 0.5 q: to the drag of a cube face-on it adds 0.5.
  CaseRecord record = sample::record("cube_incidence-000_re-1e5", dragcore::Box{}, {});
  const auto name = compare::pose_question("cube", "0", 1e5);
  compare::Reference reference = compare::merged({}, {record});
  const auto before = compare::explain_error(reference, recommended(), {}, name)[0].worst_patch;
  REQUIRE(before);
  for (compare::PatchMean& patch : reference.patches[0])
    if (patch.name == "x+") patch.pressure_force.x() += 5.0;
  const auto after = compare::explain_error(reference, recommended(), {}, name)[0].worst_patch;
  REQUIRE(after);
  CHECK(after->name == "x+");
  CHECK(after->reference > 4.0);
  // A gauge: a constant added to every pressure of the reference changes nothing of what is said of the difference.
  compare::Reference shifted = compare::merged({}, {record});
  for (compare::PatchMean& patch : shifted.patches[0]) patch.pressure_force -= 3.0 * patch.area_vector;
  const auto again = compare::explain_error(shifted, recommended(), {}, name)[0].worst_patch;
  REQUIRE(again);
  CHECK(again->name == before->name);
  CHECK(again->model - again->reference == Approx(before->model - before->reference).margin(1e-9));
}

TEST_CASE("poses as people write them, and what is not there is told with what is", "[compare][explanation][hard]") {
  CHECK(compare::pose_question("cube", "30", 1e5).incidence_deg == 30.0);
  CHECK(compare::pose_question("cube", "30", 1e5).yaw_deg == 0.0);
  CHECK(compare::pose_question("cube", "yaw=45", 1e5).yaw_deg == 45.0);
  for (const double reynolds : {std::nan(""), 0.0, -5.0})
    CHECK_THROWS_WITH(compare::pose_question("cube", "30", reynolds), Contains("above 0"));
  const auto both = compare::pose_question("cube", "incidence 20 yaw -15", 1e5);
  CHECK(both.incidence_deg == 20.0);
  CHECK(both.yaw_deg == -15.0);
  for (const char* words : {"", "yaw", "fast", "30 deg", "nan", "yaw 4x"})
    CHECK_THROWS_WITH(compare::pose_question("cube", words, 1e5), Contains("degrees are needed"));
  const auto records = sample::quick_tier();
  CHECK_THROWS_WITH(asked(records, "zeppelin", "0"), Contains("zeppelin") && Contains("cone, cube, plate"));
  CHECK_THROWS_WITH(asked(records, "cube", "yaw 7"), Contains("not stored") && Contains("yaw 45"));
}
