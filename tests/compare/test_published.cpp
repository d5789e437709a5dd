#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "compare/note_table.hpp"
#include "compare/published.hpp"
#include "tests/compare/sample_records.hpp"

namespace {

sample::CaseRecord sphere(double reynolds) {
  auto record = sample::record("sphere", dragcore::Sphere{}, {});
  record.reynolds = reynolds;
  return record;
}

}  // namespace

TEST_CASE("published values are found by body, pose and Reynolds number", "[compare][analytic]") {
  CHECK(compare::published_value(sphere(100), "C_D")->value == 1.102);
  CHECK(compare::published_value(sphere(300), "C_D")->value == 0.656);
  CHECK(compare::published_value(sphere(1e5), "C_D")->citation == "toskan2020");
  CHECK_FALSE(compare::published_value(sphere(50), "C_D"));
  CHECK_FALSE(compare::published_value(sphere(100), "C_L"));

  const auto plate = [](double incidence, double span) {
    return sample::record("plate", dragcore::Plate{.chord = 1.0, .span = span, .thickness = 0.05}, {.incidence = incidence * sample::deg});
  };
  CHECK(compare::published_value(plate(90, 1.0), "C_D")->value == 1.17);
  CHECK_FALSE(compare::published_value(plate(90, 3.0), "C_D"));
  CHECK_FALSE(compare::published_value(plate(75, 1.0), "C_D"));
  CHECK(compare::published_value(plate(45, 1.0), "force_angle_deg")->value == Approx(45.0));
  CHECK_FALSE(compare::published_value(sample::record("box", dragcore::Box{.length = 2.0}, {}), "C_D"));
  CHECK(compare::published_value(sample::record("cone", dragcore::Cone{}, {}), "C_D")->value == 0.51);
}

TEST_CASE("the edge-on cube is converted from its frontal area to the area of a face", "[compare][analytic]") {
  const auto value = compare::published_value(sample::record("box", dragcore::Box{}, {.yaw = 45 * sample::deg}), "C_D");
  REQUIRE(value);
  CHECK(value->value == Approx(0.80 * std::sqrt(2.0)).epsilon(1e-12));
  CHECK(value->uncertainty == Approx(0.05 * std::sqrt(2.0)).epsilon(1e-12));
  CHECK_FALSE(value->conversion.empty());
}

TEST_CASE("a check of the CFD says by how much it misses and whether that is within the goal", "[compare][analytic]") {
  auto record = sphere(100);
  const double scale = compare::coefficient_scales(record)[0];
  record.load = {};
  record.load.force_pressure.x() = 1.05 * 1.102 * scale;
  auto checks = compare::published_checks({record});
  REQUIRE(checks.size() == 1);
  CHECK(checks[0].difference_percent() == Approx(5.0));
  CHECK_FALSE(checks[0].within_goal());  // 3 %
  record.load.force_pressure.x() = 1.02 * 1.102 * scale;
  CHECK(compare::published_checks({record})[0].within_goal());
  record.status = case_record::Status::diverged;
  CHECK(compare::published_checks({record}).empty());
}

TEST_CASE("the note's table has its five rows, on its own areas", "[compare][analytic]") {
  const auto cube = sample::record("box_yaw-045", dragcore::Box{}, {.yaw = 45 * sample::deg});
  const auto rows = compare::note_table({cube}, {{"note", dragcore::Model{}}});
  REQUIRE(rows.size() == 5);
  for (const auto& row : rows) {
    const bool is_ours = row.label == "Cube at 45 deg";
    CHECK(row.cfd.has_value() == is_ours);
    if (!is_ours) continue;
    CHECK(row.published == 0.80);
    CHECK(*row.cfd == Approx(*compare::coefficients(cube)[compare::Channel::drag] / std::sqrt(2.0)).epsilon(1e-12));
    CHECK(*row.laws[0] == Approx(1.0 - std::sqrt(2.0) / 4.0).epsilon(1e-12));
  }
}

TEST_CASE("every citation has an entry in the bibliography", "[compare][regression]") {
  std::ifstream file(std::string(SOURCE_FOLDER) + "/references.bib");
  std::stringstream bibliography;
  bibliography << file.rdbuf();
  for (const auto& entry : compare::published_entries()) {
    INFO(entry.published.citation);
    CHECK(bibliography.str().find("{" + entry.published.citation + ",") != std::string::npos);
  }
}
