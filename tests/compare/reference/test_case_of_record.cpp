#include <catch2/catch.hpp>

#include "compare/reference/case_of_record.hpp"
#include "compare/reference/method_uncertainty.hpp"
#include "compare/tables/error_table.hpp"
#include "compare/tables/note_table.hpp"
#include "tests/compare/sample_records.hpp"

using Catch::Contains;
using Eigen::Vector3d;

namespace {

constexpr double u_run = 0.005;  // of each force channel of a sample

/// A plate at 30 degrees, solved by one method: C_N square to it, without any uncertainty but of the run.
sample::CaseRecord plate(const std::string& flow, double normal_force, const std::string& variant = "") {
  auto record = sample::record("plate_incidence-030_re-1e5" + std::string(flow == "k_omega_sst" ? "" : "-ddes_octree"), dragcore::Plate{},
                               {.incidence = 30 * sample::deg});
  if (!variant.empty()) record.name += "_" + variant;
  record.flow_model = flow;
  const double scale = compare::coefficient_scales(record)[0];
  record.load = {};
  record.load.force_pressure = normal_force * scale * Vector3d(0.5, 0.0, std::sqrt(0.75));
  record.u_iteration.setZero();
  record.u_statistical.setZero();
  record.u_statistical.head<3>().setConstant(u_run * scale);
  return record;
}

double u_force(const compare::CaseFamily& family, const compare::LoadUncertainty::Channels& u) {
  return u.head<3>().norm() / compare::coefficient_scales(*family.record)[0];
}

}  // namespace

TEST_CASE("of several methods the one whose force is known best is the case of record, its method's part included",
          "[compare][record][analytic]") {
  const std::vector records = {plate("k_omega_sst", 0.8), plate("k_omega_sst_ddes", 1.1, "up")};
  const auto cases = compare::cases_of_record(records);
  REQUIRE(cases.size() == 1);
  CHECK(cases[0].family.record->flow_model == "k_omega_sst_ddes");  // 8 % of 1.1 against 24 % of 0.8
  REQUIRE(cases[0].alternatives.size() == 1);
  const double numerical = std::sqrt(3.0) * u_run;
  CHECK(u_force(cases[0].family, cases[0].family.uncertainty.method) == Approx(0.08 * 1.1).epsilon(1e-12));
  CHECK(u_force(cases[0].family, cases[0].family.uncertainty.total) == Approx(std::hypot(0.08 * 1.1, numerical)).epsilon(1e-12));
  CHECK_THAT(cases[0].note, Contains("ddes_octree_medium_up") && Contains("not plate_incidence-030_re-1e5_medium: C_D 0.400"));
  CHECK_FALSE(cases[0].other_branch);
}

TEST_CASE("a case on one mesh does not stand for a pose that another method solved on three, unless its method holds the mesh",
          "[compare][record][regression]") {
  // A cube at 45 degrees stood on one coarse octree, u 14 %, and not on four steady meshes, u 24 %: the larger for holding the mesh.
  const auto solved = [](const std::string& stem, const dragcore::Shape& shape, const dragcore::Pose& pose, const std::string& flow,
                         const std::string& level, int cells, double force) {
    auto record = sample::record(stem, shape, pose, level, cells);
    record.flow_model = flow;
    record.load = {};
    record.load.force_pressure.x() = force;
    return record;
  };
  const auto on_record = [&](const dragcore::Shape& shape, const dragcore::Pose& pose, int steady_meshes) {
    std::vector<sample::CaseRecord> records = {solved("body-ddes_octree", shape, pose, "k_omega_sst_ddes", "coarse", 18000, 4.4)};
    const std::vector<std::tuple<std::string, int, double>> steady = {{"coarse", 5000, 4.0}, {"medium", 13000, 5.0}, {"fine", 34000, 4.5}};
    for (int i = 0; i < steady_meshes; ++i) {
      const auto& [level, cells, force] = steady[static_cast<std::size_t>(i)];
      records.push_back(solved("body", shape, pose, "k_omega_sst", level, cells, force));
    }
    const auto cases = compare::cases_of_record(records);
    REQUIRE(cases.size() == 1);
    return std::pair(cases[0].family.record->flow_model, cases[0].note);
  };
  const dragcore::Box cube;
  const dragcore::Plate plate;
  const auto [steady, note] = on_record(cube, {.yaw = 45 * sample::deg}, 3);
  CHECK(steady == "k_omega_sst");
  CHECK_THAT(note, Contains("body_fine: ") && Contains("taken, not body-ddes_octree_coarse") && Contains("the method, without the mesh"));
  CHECK(on_record(plate, {.incidence = 30 * sample::deg}, 3).first == "k_omega_sst_ddes");
  // Steady flow on one mesh knows no more of it: 8 % of the method against 14 %.
  CHECK(on_record(cube, {.yaw = 45 * sample::deg}, 1).first == "k_omega_sst");
  CHECK(on_record(plate, {.incidence = 30 * sample::deg}, 1).first == "k_omega_sst_ddes");
}

TEST_CASE("a failed solution never stands for a pose that another solved", "[compare][record][regression]") {
  auto failed = plate("k_omega_sst_ddes", 1.1, "up");
  failed.status = case_record::Status::diverged;
  const std::vector records = {failed, plate("k_omega_sst", 0.8)};
  const auto cases = compare::cases_of_record(records);
  REQUIRE(cases.size() == 1);
  CHECK(cases[0].family.record->flow_model == "k_omega_sst");
  CHECK_THAT(cases[0].note, Contains("diverged"));
}

TEST_CASE("two branches of a flow are both told, and half their difference is the least that the method leaves open",
          "[compare][record][limit]") {
  // On a branch u of the run is sqrt(3) 0.005, so 2u of the difference is 0.0245.
  const std::vector near = {plate("k_omega_sst_ddes", 1.10, "up"), plate("k_omega_sst_ddes", 1.08, "down")};
  const auto close = compare::cases_of_record(near);
  REQUIRE(close.size() == 1);
  CHECK_FALSE(close[0].other_branch);
  const std::vector far = {plate("k_omega_sst_ddes", 1.4, "up"), plate("k_omega_sst_ddes", 1.0, "down")};
  const auto apart = compare::cases_of_record(far);
  REQUIRE(apart.size() == 1);
  REQUIRE(apart[0].other_branch);
  CHECK_THAT(apart[0].note, Contains("the other of two branches"));
  CHECK(u_force(apart[0].family, apart[0].family.uncertainty.method) == Approx(0.2).epsilon(1e-12));

  const auto table = compare::compare_with({far[0], far[1], plate("k_omega_sst", 0.4)}, compare::predictor({}), "note");
  const auto& row = table.rows.front();
  REQUIRE(row.other_branch);
  CHECK(std::min(*row.cfd, *row.other_branch) == Approx(0.5).epsilon(1e-12));  // C_D of C_N 1.0 at 30 degrees
  CHECK(std::max(*row.cfd, *row.other_branch) == Approx(0.7).epsilon(1e-12));
  for (const auto format : {compare::Format::table, compare::Format::markdown, compare::Format::csv, compare::Format::json})
    CHECK_THAT(compare::render(table, format), Contains("two branches"));
}

TEST_CASE("a pose solved by several methods has one row, in the family of its flow", "[compare][record][regression]") {
  auto records = sample::quick_tier();
  const auto before = compare::compare_with(records, compare::predictor({}), "note");
  records.push_back(plate("k_omega_sst_ddes", 1.1, "up"));
  records.push_back(plate("k_omega_sst_ddes", 1.1, "down"));
  const auto after = compare::compare_with(records, compare::predictor({}), "note");
  CHECK(after.rows.size() == before.rows.size());
  CHECK(after.summaries.size() == before.summaries.size());
  CHECK(after.compared == 12);
}

TEST_CASE("a variant of the numerics stands for a pose only where nothing else was solved", "[compare][record][limit]") {
  const std::vector records = {plate("k_omega_sst", 0.8), plate("k_omega_sst", 0.7, "upwind")};
  const auto both = compare::cases_of_record(records);
  REQUIRE(both.size() == 1);
  CHECK(both[0].family.record->name == "plate_incidence-030_re-1e5_medium");
  CHECK(both[0].alternatives.empty());
  const std::vector only = {records[1]};
  const auto alone = compare::cases_of_record(only);
  REQUIRE(alone.size() == 1);
  CHECK(alone[0].family.record->name == "plate_incidence-030_re-1e5_medium_upwind");
}

TEST_CASE("laminar and turbulent flow, and bodies of other measures, are other questions", "[compare][record][limit]") {
  auto laminar = plate("laminar", 0.9);
  laminar.name = "plate_incidence-030_re-1e5-laminar_medium";
  auto wide = plate("k_omega_sst", 0.9);
  wide.name = "plate-span-2_incidence-030_re-1e5_medium";
  wide.shape = dragcore::Plate{.span = 2.0};
  CHECK(compare::cases_of_record({plate("k_omega_sst", 0.8), laminar, wide}).size() == 3);
}

TEST_CASE("the method leaves nothing open in laminar flow, most on smooth bodies and little where edges fix the separation",
          "[compare][record][limit]") {
  const auto relative = [](const dragcore::Shape& shape, const dragcore::Pose& pose, const std::string& flow) {
    auto record = sample::record("body", shape, pose);
    record.flow_model = flow;
    const auto* found = compare::method_uncertainty(record);
    REQUIRE(found);
    return found->relative;
  };
  CHECK(relative(dragcore::Sphere{}, {}, "laminar") == 0.0);
  CHECK(relative(dragcore::Sphere{}, {}, "k_omega_sst") == 0.45);
  CHECK(relative(dragcore::Box{}, {}, "k_omega_sst") == 0.04);
  CHECK(relative(dragcore::Box{}, {.yaw = 45 * sample::deg}, "k_omega_sst") == 0.08);
  CHECK(relative(dragcore::Plate{}, {.incidence = 90 * sample::deg}, "k_omega_sst") == 0.04);
  // -10 to +45 %, nothing known between: the root mean square of a uniform distribution about the value itself.
  const double a = 0.10, b = 0.45;
  for (const double incidence : {15.0, 30.0, 45.0})
    CHECK(relative(dragcore::Plate{}, {.incidence = incidence * sample::deg}, "k_omega_sst") ==
          Approx(std::sqrt((a * a - a * b + b * b) / 3.0)).margin(0.005));
  // A disc's own axis is square to it: 60 degrees of axis are 30 degrees of disc.
  CHECK(relative(dragcore::Cylinder{.diameter = 1.0, .length = 0.05}, {.incidence = 60 * sample::deg}, "k_omega_sst") == 0.24);
  CHECK(relative(dragcore::Cylinder{.diameter = 1.0, .length = 0.05}, {}, "k_omega_sst") == 0.04);
}

TEST_CASE("a spin in still air and the same spin in a wind are two questions", "[compare][spin]") {
  const auto still = sample::spinning("cube_spin-z_re-1e2-laminar", dragcore::Box{}, {0.0, 0.0, 2.0}, -0.10, 100);
  auto windy = still;
  windy.name = "cube_incidence-000_spin-z-1_re-1e2-laminar_" + still.mesh_level;
  windy.key.front() = 'w';
  windy.still_air = false;
  CHECK(compare::cases_of_record({still, windy}).size() == 2);
}

TEST_CASE("turbulent methods answer the same question, laminar flow another", "[compare][record]") {
  const auto flow_class = [](const char* model) {
    sample::CaseRecord record;
    record.flow_model = model;
    return compare::flow_class(record);
  };
  for (const char* model : {"k_omega_sst", "k_omega_sst_ddes", "k_omega_sst_lm"}) CHECK(flow_class(model) == "k_omega_sst");
  for (const char* model : {"laminar", "laminar_unsteady"}) CHECK(flow_class(model) == "laminar");
}
