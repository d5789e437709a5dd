#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "compare/tables/variants.hpp"
#include "tests/compare/sample_records.hpp"

using Catch::Contains;
using Eigen::Vector3d;

namespace {

/// A cube at yaw 30: C_D, C_S and C_n.
sample::CaseRecord cube(const std::string& variant, double drag, double side, double moment, const std::string& level = "medium",
                        int cells = 12000) {
  auto record = sample::record("cube_yaw-030_re-1e5", dragcore::Box{}, {.yaw = 30 * sample::deg}, level, cells);
  if (!variant.empty()) record.name += "_" + variant;
  record.load = {};
  record.load.force_pressure = compare::coefficient_scales(record)[0] * Vector3d(drag, side, 0.0);
  record.load.moment_pressure = compare::coefficient_scales(record)[3] * Vector3d(0.0, 0.0, moment);
  return record;
}

}  // namespace

TEST_CASE("a variant is compared with its base: in % of its force and moment, in units of u_disc, and by its cost",
          "[compare][variants][analytic]") {
  auto base = cube("", 0.8, 0.6, 0.05), coarse = cube("", 0.9, 0.6, 0.05, "coarse", 1500);
  auto upwind = cube("upwind", 0.83, 0.59, 0.04);
  upwind.cost = {{"mesh", {2.5, 2.6}}, {"solve", {5.25, 5.5}}};  // the base: 2.5 and 13 CPU seconds
  const auto table = compare::variant_table({base, coarse, upwind});
  REQUIRE(table.rows.size() == 1);
  CHECK(table.compared == 1);
  const auto& row = table.rows[0];
  CHECK(row.base == base.name);
  CHECK(row.variant == "upwind");
  CHECK(row.drag.percent.value() == Approx(3.0).epsilon(1e-10));  // 0.03 of a force of 1
  CHECK(row.lateral.percent.value() == Approx(-1.0).epsilon(1e-10));
  CHECK(row.moment.percent.value() == Approx(-20.0).epsilon(1e-10));
  CHECK(row.drag.in_u.value() == Approx(0.03 / (1.5 * 0.1 / 3.0)).epsilon(1e-10));  // two levels, ratio of sizes 2
  CHECK(row.cpu_ratio.value() == Approx(0.5).epsilon(1e-12));
}

TEST_CASE("a variant without a base on its own level is listed and not compared", "[compare][variants][limit]") {
  const auto table = compare::variant_table({cube("", 0.8, 0.6, 0.05, "fine"), cube("upwind", 0.8, 0.6, 0.05)});
  CHECK(table.compared == 0);
  CHECK(table.rows.empty());
  REQUIRE(table.without_base.size() == 1);
  CHECK_THAT(table.without_base[0], Contains("_upwind"));
}

TEST_CASE("of a flow followed up and down in angle the way up is the base", "[compare][variants]") {
  const auto table = compare::variant_table({cube("down", 0.6, 0.6, 0.05), cube("up", 0.8, 0.6, 0.05), cube("up-coarse", 0.7, 0.6, 0.05)});
  REQUIRE(table.rows.size() == 2);
  CHECK(table.rows[0].variant == "down");
  CHECK(table.rows[0].drag.percent.value() == Approx(-20.0).epsilon(1e-10));
  CHECK(table.rows[1].variant == "up-coarse");
  CHECK(table.without_base.empty());
  // Where there is a case without variant, it is.
  CHECK(compare::variant_table({cube("", 0.8, 0.6, 0.05), cube("up", 0.8, 0.6, 0.05)}).rows.at(0).variant == "up");
}

TEST_CASE("seeds have a scatter, the base among them", "[compare][variants][analytic]") {
  const auto table = compare::variant_table(
      {cube("", 0.79, 0.6, 0.05), cube("seed-2", 0.80, 0.6, 0.05), cube("seed-3", 0.81, 0.6, 0.05), cube("upwind", 0.9, 0.6, 0.05)});
  REQUIRE(table.seeds.size() == 1);
  CHECK(table.seeds[0].n == 3);
  CHECK(table.seeds[0].drag.percent.value() ==
        Approx(100.0 * 0.01 / std::hypot(0.79, 0.6)).epsilon(1e-10));  // standard deviation of -1, 0, 1
  CHECK(table.seeds[0].lateral.percent.value() == Approx(0.0).margin(1e-10));
  CHECK_FALSE(table.seeds[0].drag.in_u);  // one level: u_disc is not known
}

TEST_CASE("a moment next to nothing has no percentages, and a failed variant keeps its row", "[compare][variants][limit]") {
  auto failed = cube("no_limiter", 0.8, 0.6, 0.0);
  failed.status = case_record::Status::diverged;
  failed.reason = "C_D reached -2e4";
  const auto table = compare::variant_table({cube("", 0.8, 0.6, 1e-5), cube("upwind", 0.8, 0.6, 2e-5), failed});
  REQUIRE(table.rows.size() == 2);
  CHECK(table.compared == 1);
  CHECK_FALSE(table.rows[0].moment.percent);
  CHECK_FALSE(table.rows[1].drag.percent);
  for (const auto format : {compare::Format::table, compare::Format::markdown, compare::Format::csv, compare::Format::json})
    CHECK_THAT(compare::render(table, format), Contains("upwind") && Contains("C_D reached -2e4"));
}

TEST_CASE("variants of a body that spins differ in torque about its axis", "[compare][variants][spin]") {
  auto base = sample::spinning("cube_spin-z_re-1e2-laminar", dragcore::Box{}, {0.0, 0.0, 2.0}, -0.10, 100);
  auto variant = sample::spinning("cube_spin-z_re-1e2-laminar", dragcore::Box{}, {0.0, 0.0, 2.0}, -0.11, 100);
  variant.name += "_far-20";
  const auto table = compare::variant_table({base, variant});
  REQUIRE(table.rows.size() == 1);
  CHECK_FALSE(table.rows[0].drag.percent);
  CHECK(table.rows[0].moment.percent.value() == Approx(-10.0).epsilon(1e-10));  // -0.01 of a torque of 0.1: brakes more
}
