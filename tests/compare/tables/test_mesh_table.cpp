#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "compare/tables/mesh_table.hpp"
#include "tests/compare/sample_records.hpp"

using Catch::Contains;
using Eigen::Vector3d;

namespace {

/// A cube whose drag is `drag`, in half of which the mesh has no part.
sample::CaseRecord cube(const std::string& stem, double drag, const std::string& level, int cells) {
  auto record = sample::record(stem, dragcore::Box{}, {}, level, cells);
  record.load = {};
  record.load.force_pressure = Vector3d(drag, 0.0, 0.0);
  record.u_null.setZero();
  return record;
}

}  // namespace

TEST_CASE("what the mesh leaves open is counted by body and flow, by how it was found, against its aim", "[compare][truth][analytic]") {
  // Two levels with cells 8 : 1, sizes 2 : 1: u = 3/2 |difference| / (2^2 - 1).
  const std::vector<sample::CaseRecord> records{cube("cube_a_re-1e5", 1.00, "medium", 8000), cube("cube_a_re-1e5", 1.02, "coarse", 1000),
                                                cube("cube_b_re-1e5", 2.00, "medium", 8000), cube("cube_b_re-1e5", 2.40, "coarse", 1000),
                                                cube("cube_c_re-1e5", 1.00, "medium", 8000)};
  const auto rows = compare::mesh_rows(records);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].aim == 0.03);
  CHECK(rows[0].poses == 3);
  CHECK(rows[0].two_levels == 2);
  CHECK(rows[0].unknown == 1);
  CHECK(rows[0].within_aim == 1);
  CHECK(rows[0].largest == Approx(0.5 * 0.4 / 2.0).epsilon(1e-12));
  CHECK_THAT(rows[0].worst, Contains("cube_b") && Contains("two levels"));
  for (const auto format : {compare::Format::table, compare::Format::markdown, compare::Format::csv, compare::Format::json})
    CHECK_THAT(compare::render(rows, format), Contains("cube_b"));
}

TEST_CASE("a force that symmetry forbids is held against what else is open; spins and variants are not counted",
          "[compare][truth][limit]") {
  auto medium = cube("cube_a_re-1e5", 1.00, "medium", 8000);
  medium.u_iteration.setZero(), medium.u_statistical.setZero();
  medium.u_null[2] = 0.02;  // twice what the mesh leaves open of the drag, 0.5 * 0.02
  auto variant = cube("cube_a_re-1e5", 1.5, "medium", 8000);
  variant.name += "_upwind";
  const auto rows = compare::mesh_rows({medium, cube("cube_a_re-1e5", 1.02, "coarse", 1000), variant,
                                        sample::spinning("cube_spin-z_re-1e2", dragcore::Box{}, {0, 0, 2}, -0.1, 100)});
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].poses == 1);
  CHECK(rows[0].null == Approx(2.0).epsilon(1e-10));
}

TEST_CASE("a finest mesh is held against what the meshes before it said", "[compare][truth][analytic]") {
  // Sizes 4 : 2 : 1 (: 1/2). Two meshes of second order with difference d leave 2u = 3 d / 3 = d for what comes.
  std::vector<sample::CaseRecord> records{cube("cube_a_re-1e5", 1.160, "coarse", 1000), cube("cube_a_re-1e5", 1.040, "medium", 8000),
                                          cube("cube_a_re-1e5", 1.010, "fine", 64000),  cube("cube_b_re-1e5", 1.160, "coarse", 1000),
                                          cube("cube_b_re-1e5", 1.040, "medium", 8000), cube("cube_b_re-1e5", 1.280, "fine", 64000),
                                          cube("cube_c_re-1e5", 1.320, "coarse", 1000), cube("cube_c_re-1e5", 1.080, "medium", 8000),
                                          cube("cube_c_re-1e5", 1.020, "fine", 64000),  cube("cube_c_re-1e5", 1.005, "finest", 512000),
                                          cube("cube_d_re-1e5", 1.160, "coarse", 1000), cube("cube_d_re-1e5", 1.040, "medium", 8000)};
  const auto turbulent = compare::held_back_rows(records);
  REQUIRE(turbulent.size() == 2);
  CHECK(turbulent[0].rule == "three or more, factor 3");  // an order of two earns nothing where wakes may change
  CHECK(turbulent[0].largest == Approx(0.015 / (3.0 * 0.02)).epsilon(1e-3));
  for (auto& record : records) record.flow_model = "laminar";
  const auto rows = compare::held_back_rows(records);
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].rule == "three or more, factor 1.25");  // c: second order exactly, error 0.02 on the third, 2u = 1.25 times that
  CHECK(rows[0].poses == 1);
  CHECK(rows[0].largest == Approx(0.015 / (1.25 * 0.02)).epsilon(1e-3));
  CHECK(rows[1].rule == "two meshes, factor 3");
  CHECK(rows[1].poses == 2);
  CHECK(rows[1].within == 1);
  CHECK(rows[1].largest == Approx(2.0).epsilon(1e-12));
  CHECK_THAT(rows[1].worst, Contains("cube_b"));
  for (const auto format : {compare::Format::table, compare::Format::markdown, compare::Format::csv, compare::Format::json})
    CHECK_THAT(compare::render(rows, format), Contains("cube_b"));
}
