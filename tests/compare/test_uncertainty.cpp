#include <catch2/catch.hpp>

#include "compare/uncertainty.hpp"
#include "tests/compare/sample_records.hpp"

using Catch::Contains;
using compare::grid_study;

namespace {

/// phi = limit + a h^p on meshes of these cell sizes relative to the finest, which has 100,000 cells.
std::pair<std::vector<double>, std::vector<double>> series(double limit, double a, double p, const std::vector<double>& sizes) {
  std::pair<std::vector<double>, std::vector<double>> result;
  for (const double h : sizes) {
    result.first.push_back(1e5 / (h * h * h));
    result.second.push_back(limit + a * std::pow(h, p));
  }
  return result;
}

}  // namespace

TEST_CASE("four meshes of a known order give back the order, the limit and 1.25 times the error", "[compare][analytic]") {
  const double p = 1.6;
  const auto [cells, values] = series(1.1, 0.03, p, {1.0, 1.5, 2.25, 3.375});
  const auto study = grid_study(cells, values);
  CHECK(study.order == Approx(p).margin(1e-4));  // Brent's method on a sum of squares: square root of rounding
  CHECK(study.extrapolated == Approx(1.1).margin(1e-5));
  CHECK(2.0 * study.uncertainty == Approx(1.25 * 0.03).epsilon(1e-3));  // no scatter: only the safety factor
  CHECK_THAT(study.branch, Contains("observed order 1.60") && Contains("1.25"));
}

TEST_CASE("the order of the meshes in the list does not matter", "[compare][invariance]") {
  const auto [cells, values] = series(1.0, 0.02, 1.2, {1.0, 1.4, 2.0, 2.9});
  const auto study = grid_study(cells, values);
  const auto shuffled = grid_study({cells[2], cells[0], cells[3], cells[1]}, {values[2], values[0], values[3], values[1]});
  CHECK(shuffled.uncertainty == study.uncertainty);
}

TEST_CASE("the uncertainty scales with the quantity", "[compare][invariance]") {
  auto [cells, values] = series(1.0, 0.02, 1.2, {1.0, 1.4, 2.0, 2.9});
  values[1] += 0.001;
  const double u = grid_study(cells, values).uncertainty;
  for (double& value : values) value = -1e-7 * value + 3.0;
  CHECK(grid_study(cells, values).uncertainty == Approx(1e-7 * u).epsilon(1e-4));  // 1e-7 of 3 keeps nine digits, the differences five
}

TEST_CASE("three meshes are trusted less than four", "[compare][limit]") {
  const auto [cells, values] = series(1.1, 0.03, 1.6, {1.0, 1.5, 2.25});
  const auto study = grid_study(cells, values);
  CHECK(2.0 * study.uncertainty == Approx(3.0 * 0.03).epsilon(1e-3));
  CHECK_THAT(study.branch, Contains("safety factor 3"));
}

TEST_CASE("three meshes that oscillate get three times their range", "[compare][limit]") {
  const auto study = grid_study({1e5, 3e4, 1e4}, {1.00, 1.02, 1.01});
  CHECK(2.0 * study.uncertainty == Approx(3.0 * 0.02).epsilon(1e-12));
  CHECK_THAT(study.branch, Contains("data range"));
}

TEST_CASE("an order above two falls back on fixed orders with the large safety factor", "[compare][limit]") {
  const auto [cells, values] = series(1.0, 0.001, 4.0, {1.0, 1.5, 2.25, 3.375});
  const auto study = grid_study(cells, values);
  CHECK_THAT(study.branch, Contains("second-order fit") && Contains("observed order 4.0"));
  CHECK(2.0 * study.uncertainty > 3.0 * 0.001);  // wider than three times the true error on the finest mesh
}

TEST_CASE("scatter beyond the data spread widens the uncertainty beyond the range", "[compare][limit]") {
  const auto study = grid_study({1e5, 5e4, 2.5e4, 1.2e4, 6e3}, {1.00, 1.05, 0.97, 1.04, 0.99});
  CHECK(2.0 * study.uncertainty > 0.08);
}

TEST_CASE("equal values on all meshes have no discretisation uncertainty", "[compare][limit]") {
  CHECK(grid_study({1e5, 3e4, 1e4}, {0.0, 0.0, 0.0}).uncertainty == 0.0);
}

TEST_CASE("the same mesh twice, too few meshes and broken numbers are refused", "[compare][hard]") {
  CHECK_THROWS_WITH(grid_study({1e5, 1e5, 1e4}, {1.0, 1.0, 1.1}), Contains("same mesh twice"));
  CHECK_THROWS_WITH(grid_study({1e5, 1e4}, {1.0, 1.1}), Contains("at least 3"));
  CHECK_THROWS_WITH(grid_study({1e5, 3e4, 1e4}, {1.0, 1.1}), Contains("one value per mesh"));
  CHECK_THROWS_WITH(grid_study({1e5, 3e4, 0.0}, {1.0, 1.1, 1.2}), Contains("positive"));
  CHECK_THROWS_WITH(grid_study({1e5, 3e4, 1e4}, {1.0, NAN, 1.2}), Contains("finite"));
}

TEST_CASE("the finest usable mesh is the case of record and carries all parts of u", "[compare][analytic]") {
  std::vector<sample::CaseRecord> records;
  const std::vector<std::pair<std::string, int>> levels = {{"coarse", 4000}, {"medium", 13500}, {"fine", 45562}, {"finest", 153773}};
  for (const auto& [level, cells] : levels) {
    records.push_back(sample::record("sphere_re-1e2", dragcore::Sphere{}, {}, level, cells));
    records.back().load.force_pressure.x() = 1.0 + 1e2 * std::pow(cells, -2.0 / 3.0);  // second order in h
  }
  records[3].status = case_record::Status::diverged;
  const auto families = compare::case_families(records);
  REQUIRE(families.size() == 1);
  CHECK(families[0].record->mesh_level == "fine");
  CHECK(families[0].levels.size() == 4);
  const auto& u = families[0].uncertainty;
  CHECK(u.discretisation_assessed);
  const double error = 1e2 * std::pow(45562, -2.0 / 3.0);
  CHECK(2.0 * u.discretisation[0] ==
        Approx(3.0 * error).epsilon(0.01));  // three usable meshes: factor 3; order 2.00 within Brent's accuracy
  CHECK(u.total[0] == Approx(std::sqrt(u.discretisation[0] * u.discretisation[0] + 0.005 * 0.005)).epsilon(1e-12));  // 3-4-5
}

TEST_CASE("with fewer than three levels the part of the mesh is marked as not assessed, with two equal meshes as refused",
          "[compare][limit]") {
  std::vector<sample::CaseRecord> records = {sample::record("box_re-1e5", dragcore::Box{}, {}, "medium", 12000),
                                             sample::record("box_re-1e5", dragcore::Box{}, {}, "fine", 36000)};
  CHECK_FALSE(compare::case_families(records)[0].uncertainty.discretisation_assessed);
  records.push_back(sample::record("box_re-1e5", dragcore::Box{}, {}, "finest", 36000));
  const auto family = compare::case_families(records)[0];
  CHECK_FALSE(family.uncertainty.discretisation_assessed);
  REQUIRE(family.uncertainty.branches.size() == 1);
  CHECK_THAT(family.uncertainty.branches[0], Contains("refused") && Contains("36000"));
}

TEST_CASE("mesh levels are taken off case names, variants are not", "[compare][analytic]") {
  CHECK(compare::family_name("box_yaw-045_re-1e5_medium", "medium") == "box_yaw-045_re-1e5");
  CHECK(compare::family_name("box_yaw-045_re-1e5_medium_limited", "medium") == "box_yaw-045_re-1e5_limited");
  CHECK(compare::family_name("box_mediumish", "medium") == "box_mediumish");
}
