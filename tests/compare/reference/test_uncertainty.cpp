#include <catch2/catch.hpp>

#include "compare/reference/uncertainty.hpp"
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

TEST_CASE("three meshes are trusted less than four: from an order of one on", "[compare][limit]") {
  const auto wide = [](double order, const std::vector<double>& sizes) {
    const auto [cells, values] = series(1.1, 0.03, order, sizes);
    return 2.0 * grid_study(cells, values).uncertainty / 0.03;
  };
  CHECK(wide(1.6, {1.0, 1.5, 2.25}) == Approx(1.25).epsilon(1e-3));
  CHECK(wide(0.7, {1.0, 1.5, 2.25}) == Approx(3.0).epsilon(1e-3));
  CHECK(wide(0.7, {1.0, 1.5, 2.25, 3.375}) == Approx(1.25).epsilon(1e-3));
}

TEST_CASE("three meshes that fall faster than the scheme can are taken to fall at its order, which leaves more to go", "[compare][limit]") {
  const auto [cells, values] = series(1.0, 0.004, 3.0, {1.0, 1.5, 2.25});
  const auto study = grid_study(cells, values);
  CHECK_THAT(study.branch, Contains("second-order fit") && Contains("observed order 3.0") && Contains("safety factor 3"));
  CHECK(2.0 * study.uncertainty > 3.0 * 0.004);                    // wider than three times the true error on the finest mesh
  CHECK(2.0 * study.uncertainty < 3.0 * (values[2] - values[0]));  // and narrower than what three meshes without a trend get
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
  // Nothing but scatter: never more than three meshes without a trend get, three times the range.
  const auto wild = grid_study({1e5, 5e4, 2.5e4, 1.2e4}, {1.00, 1.08, 1.00, 1.08});
  CHECK_THAT(wild.branch, Contains("scatter above the data spread"));
  CHECK(2.0 * wild.uncertainty <= 3.0 * 0.08 * (1 + 1e-12));
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
  CHECK(2.0 * compare::case_families(records)[0].uncertainty.discretisation[0] ==
        Approx(3.0 * 1e2 * std::pow(45562, -2.0 / 3.0)).epsilon(0.01));  // a turbulent flow keeps the factor 3; accuracy as below
  for (auto& record : records) record.flow_model = "laminar";
  const auto families = compare::case_families(records);
  REQUIRE(families.size() == 1);
  CHECK(families[0].record->mesh_level == "fine");
  CHECK(families[0].levels.size() == 4);
  const auto& u = families[0].uncertainty;
  CHECK(u.discretisation_assessed);
  const double error = 1e2 * std::pow(45562, -2.0 / 3.0);
  CHECK(2.0 * u.discretisation[0] ==
        Approx(1.25 * error).epsilon(0.01));  // three usable meshes: factor 1.25; order 2.00 within Brent's accuracy
  CHECK(u.total[0] == Approx(std::sqrt(u.discretisation[0] * u.discretisation[0] + 0.005 * 0.005)).epsilon(1e-12));  // 3-4-5
}

TEST_CASE("two meshes of a second-order method give the limit and three times the error on the finer", "[compare][analytic]") {
  const auto [cells, values] = series(1.1, 0.03, 2.0, {1.0, 1.4});
  const auto study = compare::two_grid_study(cells, values);
  CHECK(study.extrapolated == Approx(1.1).epsilon(1e-12));  // exact but for rounding: the assumed order is the true one
  CHECK(2.0 * study.uncertainty == Approx(3.0 * 0.03).epsilon(1e-10));
  CHECK_THAT(study.branch, Contains("two levels") && Contains("order 2") && Contains("safety factor 3"));
  CHECK(compare::two_grid_study({cells[1], cells[0]}, {values[1], values[0]}).uncertainty == study.uncertainty);
}

TEST_CASE("two estimates from the same mesh, or from one or three, are refused", "[compare][hard]") {
  CHECK_THROWS_WITH(compare::two_grid_study({1e5, 1e5}, {1.0, 1.1}), Contains("same mesh twice"));
  CHECK_THROWS_WITH(compare::two_grid_study({1e5}, {1.0}), Contains("takes two"));
  CHECK_THROWS_WITH(compare::two_grid_study({1e5, 3e4, 1e4}, {1.0, 1.1, 1.2}), Contains("takes two"));
  CHECK_THROWS_WITH(compare::two_grid_study({1e5, 3e4}, {1.0, NAN}), Contains("finite"));
}

namespace {

/// A cube whose force is this vector of coefficients, without moment.
sample::CaseRecord cube(double yaw_deg, const std::string& level, int cells, const Eigen::Vector3d& force) {
  auto record = sample::record("cube_yaw-" + std::to_string(static_cast<int>(yaw_deg)) + "_re-1e5", dragcore::Box{},
                               {.yaw = yaw_deg * sample::deg}, level, cells);
  record.load = {};
  record.load.force_pressure = force * compare::coefficient_scales(record)[0];
  return record;
}

/// Three meshes of order one, whose C_D is 1.2 + 0.04 h.
std::vector<sample::CaseRecord> three_cubes_at_45() {
  return {cube(45, "coarse", 12500, {1.28, 0.0, 0.0}), cube(45, "medium", 100000, {1.24, 0.0, 0.0}),
          cube(45, "fine", 800000, {1.22, 0.0, 0.0})};
}

const compare::CaseFamily& family_at(const std::vector<compare::CaseFamily>& families, const std::string& name) {
  for (const auto& family : families)
    if (family.name == name) return family;
  throw std::runtime_error("no family " + name);
}

double part_of_mesh(const compare::CaseFamily& family, int channel) {
  return family.uncertainty.discretisation[channel] / compare::coefficient_scales(*family.record)[channel];
}

}  // namespace

TEST_CASE("a case on one mesh carries the error that its level has in the nearest family of three", "[compare][analytic]") {
  auto records = three_cubes_at_45();
  records.push_back(cube(30, "medium", 90000, {0.9, 0.3, 0.0}));
  const auto families = compare::case_families(records);
  const auto& family = family_at(families, "cube_yaw-30_re-1e5");
  REQUIRE(family.uncertainty.discretisation_assessed);
  // Finest of the three: order 1, error 0.02, safety factor 3. Its medium mesh is another 0.02 away.
  const double fine = 3.0 * 0.02 / 2.0, ratio = std::hypot(0.02, fine) / 1.22;
  CHECK(part_of_mesh(family, 0) == Approx(ratio * 0.9).epsilon(1e-3));  // Brent's accuracy in the order
  CHECK(part_of_mesh(family, 1) == Approx(ratio * 0.3).epsilon(1e-3));
  const double force = std::hypot(0.9, 0.3);  // a share of it where a channel is nearly zero
  CHECK(part_of_mesh(family, 2) == Approx(ratio * 0.3 * force).epsilon(1e-3));
  CHECK(part_of_mesh(family, 5) == Approx(ratio * 0.1 * force).epsilon(1e-3));  // and no moment is surer than the force
  CHECK_THAT(family.uncertainty.branches[0], Contains("carried from cube_yaw-45_re-1e5 medium: 3 %"));
}

TEST_CASE("what is carried comes from the same body, if it can, before it comes from the nearest pose", "[compare][limit]") {
  auto records = three_cubes_at_45();
  auto long_box = sample::record("box_yaw-30_re-1e5", dragcore::Box{.length = 4.0}, {.yaw = 30 * sample::deg}, "medium", 90000);
  long_box.surface_checksum = "a long box";
  for (auto& cube_record : records) cube_record.shape = dragcore::Box{.length = 2.0}, cube_record.surface_checksum = "a box";
  records.push_back(long_box);
  const auto nearest = compare::case_families(records);
  CHECK_THAT(family_at(nearest, "box_yaw-30_re-1e5").uncertainty.branches[0], Contains("carried from cube_yaw-45"));
  for (auto [level, cells, drag] : {std::tuple("coarse", 12500, 1.08), {"medium", 100000, 1.04}, {"fine", 800000, 1.02}}) {
    auto other = sample::record("box_yaw-90_re-1e5", dragcore::Box{.length = 4.0}, {.yaw = 90 * sample::deg}, level, cells);
    other.surface_checksum = "a long box";
    other.load = {};
    other.load.force_pressure = Eigen::Vector3d(drag, 0, 0) * compare::coefficient_scales(other)[0];
    records.push_back(other);
  }
  const auto same = compare::case_families(records);
  CHECK_THAT(family_at(same, "box_yaw-30_re-1e5").uncertainty.branches[0], Contains("carried from box_yaw-90"));
}

TEST_CASE("of two alike, what is carried comes from the nearer Reynolds number", "[compare][limit]") {
  auto records = three_cubes_at_45();
  for (auto [level, cells, drag] : {std::tuple("coarse", 12500, 2.7), {"medium", 100000, 2.35}, {"fine", 800000, 2.2}}) {
    auto slow = cube(45, level, cells, {drag, 0.0, 0.0});
    slow.name.replace(slow.name.find("1e5"), 3, "1e2");
    slow.reynolds = 100.0;
    records.push_back(slow);
  }
  for (const double reynolds : {10.0, 1e4}) {
    auto alone = cube(45, "medium", 90000, {3.0, 0.0, 0.0});
    alone.name.replace(alone.name.find("1e5"), 3, reynolds > 100.0 ? "1e4" : "1e1");
    alone.reynolds = reynolds;
    records.push_back(alone);
  }
  const auto families = compare::case_families(records);
  CHECK_THAT(family_at(families, "cube_yaw-45_re-1e1").uncertainty.branches[0], Contains("carried from cube_yaw-45_re-1e2"));
  CHECK_THAT(family_at(families, "cube_yaw-45_re-1e4").uncertainty.branches[0], Contains("carried from cube_yaw-45_re-1e5"));
}

TEST_CASE("a family of three levels does not change when others carry from it", "[compare][invariance]") {
  const auto alone = three_cubes_at_45();
  auto records = alone;
  records.push_back(cube(30, "medium", 90000, {0.9, 0.3, 0.0}));
  const auto before = compare::case_families(alone), after = compare::case_families(records);
  const auto &a = before[0].uncertainty, &b = family_at(after, "cube_yaw-45_re-1e5").uncertainty;
  CHECK(a.discretisation == b.discretisation);
  CHECK(a.branches == b.branches);
}

TEST_CASE("two levels count where they differ by more than what is carried, and never less", "[compare][limit]") {
  const auto found = [](double coarse) {
    auto records = three_cubes_at_45();
    records.push_back(cube(0, "coarse", 12500, {coarse, 0.0, 0.0}));
    records.push_back(cube(0, "medium", 100000, {1.0, 0.0, 0.0}));
    const auto families = compare::case_families(records);
    return std::pair(part_of_mesh(family_at(families, "cube_yaw-0_re-1e5"), 0),
                     family_at(families, "cube_yaw-0_re-1e5").uncertainty.branches[0]);
  };
  const double carried = std::hypot(0.02, 0.03) / 1.22;
  const auto [small, small_branch] = found(1.01);  // ratio of sizes 2: u = 3/2 * 0.01 / 3
  CHECK(small == Approx(carried).epsilon(1e-3));
  CHECK_THAT(small_branch, Contains("two levels") && Contains("less than carried"));
  const auto [large, large_branch] = found(1.30);
  CHECK(large == Approx(1.5 * 0.30 / 3.0).epsilon(1e-10));
  CHECK_THAT(large_branch, Contains("two levels") && Contains("more than carried"));
}

TEST_CASE("nothing is carried between flow models, kinds of shape, or levels that were not solved", "[compare][limit]") {
  auto records = three_cubes_at_45();
  auto laminar = cube(10, "medium", 90000, {1.0, 0.0, 0.0});
  laminar.flow_model = "laminar";
  auto box = sample::record("box_re-1e5", dragcore::Box{.length = 2.0}, {}, "medium", 90000);
  records.insert(records.end(), {laminar, box, cube(20, "finest", 90000, {1.0, 0.0, 0.0})});
  const auto families = compare::case_families(records);
  for (const char* name : {"cube_yaw-10_re-1e5", "box_re-1e5", "cube_yaw-20_re-1e5"}) {
    const auto& u = family_at(families, name).uncertainty;
    CHECK_FALSE(u.discretisation_assessed);
    REQUIRE(u.branches.size() == 1);
    CHECK_THAT(u.branches[0], Contains("not assessed"));
  }
}

TEST_CASE("a variant of the numerics neither joins the ordinary family nor lends its mesh error", "[compare][limit]") {
  auto records = three_cubes_at_45();
  for (auto& record : records) record.name += "_upwind";
  records.push_back(cube(45, "medium", 90000, {1.0, 0.0, 0.0}));
  const auto families = compare::case_families(records);
  REQUIRE(families.size() == 2);
  CHECK(family_at(families, "cube_yaw-45_re-1e5_upwind").levels.size() == 3);
  CHECK_FALSE(family_at(families, "cube_yaw-45_re-1e5").uncertainty.discretisation_assessed);
}

TEST_CASE("meshes that are refused leave the part of the mesh to what can be carried, or not assessed", "[compare][limit]") {
  std::vector<sample::CaseRecord> records = {cube(0, "medium", 12000, {1.0, 0.0, 0.0}), cube(0, "fine", 12000, {1.0, 0.0, 0.0})};
  const auto alone = compare::case_families(records);
  CHECK_FALSE(alone[0].uncertainty.discretisation_assessed);
  REQUIRE(alone[0].uncertainty.branches.size() == 1);
  CHECK_THAT(alone[0].uncertainty.branches[0], Contains("refused") && Contains("12000"));
  for (const auto& record : three_cubes_at_45()) records.push_back(record);
  const auto families = compare::case_families(records);
  const auto& u = family_at(families, "cube_yaw-0_re-1e5").uncertainty;
  CHECK(u.discretisation_assessed);
  CHECK_THAT(u.branches[0], Contains("refused") && Contains("carried from"));
}

TEST_CASE("mesh levels are taken off case names, variants are not", "[compare][analytic]") {
  CHECK(compare::family_name("box_yaw-045_re-1e5_medium", "medium") == "box_yaw-045_re-1e5");
  CHECK(compare::family_name("box_yaw-045_re-1e5_medium_limited", "medium") == "box_yaw-045_re-1e5_limited");
  CHECK(compare::family_name("box_mediumish", "medium") == "box_mediumish");
  CHECK(compare::family_name("box_re-1e5_medium_from_medium", "medium") == "box_re-1e5_from_medium");
  CHECK(compare::split_name("box_re-1e5_medium_seed-2", "medium").variant == "seed-2");
}
