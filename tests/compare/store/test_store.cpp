#include <hdf5.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <limits>
#include <thread>

#include "compare/store/hdf5.hpp"
#include "compare/store/store.hpp"
#include "tests/compare/sample_records.hpp"

using Catch::Contains;
using sample::CaseRecord;

namespace {

std::string bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void check_equal(const CaseRecord& a, const CaseRecord& b) {
  CHECK(a.name == b.name);
  CHECK(a.key == b.key);
  CHECK(a.description == b.description);
  CHECK(a.source == b.source);
  CHECK(a.tier == b.tier);
  CHECK(dragcore::kind(a.shape) == dragcore::kind(b.shape));
  CHECK(dragcore::parameters(a.shape) == dragcore::parameters(b.shape));
  // Poses are stored in degrees, rounded to 1e-9.
  CHECK(a.pose.incidence == Approx(b.pose.incidence).margin(1e-10));
  CHECK(a.pose.yaw == Approx(b.pose.yaw).margin(1e-10));
  CHECK(a.pose.roll == Approx(b.pose.roll).margin(1e-10));
  CHECK(a.reynolds == b.reynolds);
  CHECK(a.flow_model == b.flow_model);
  CHECK(a.mesh_level == b.mesh_level);
  CHECK(a.held_out == b.held_out);
  CHECK(a.density == b.density);
  CHECK(a.speed == b.speed);
  CHECK(a.viscosity == b.viscosity);
  CHECK(a.status == b.status);
  CHECK(a.reason == b.reason);
  REQUIRE(a.attempts.size() == b.attempts.size());
  for (std::size_t i = 0; i < a.attempts.size(); ++i) {
    CHECK(a.attempts[i].recipe == b.attempts[i].recipe);
    CHECK(a.attempts[i].status == b.attempts[i].status);
    CHECK(a.attempts[i].reason == b.attempts[i].reason);
  }
  for (const auto load : {&CaseRecord::load, &CaseRecord::load_last}) {
    CHECK((a.*load).force_pressure == (b.*load).force_pressure);
    CHECK((a.*load).force_viscous == (b.*load).force_viscous);
    CHECK((a.*load).moment_pressure == (b.*load).moment_pressure);
    CHECK((a.*load).moment_viscous == (b.*load).moment_viscous);
  }
  CHECK(a.half_model == b.half_model);
  CHECK(a.iterations == b.iterations);
  CHECK(a.averaged_over == b.averaged_over);
  CHECK(a.u_iteration == b.u_iteration);
  CHECK(a.u_statistical == b.u_statistical);
  CHECK(a.u_null == b.u_null);
  CHECK(a.u_stated == b.u_stated);
  CHECK(a.known == b.known);
  CHECK(a.cells == b.cells);
  CHECK(a.mesh_quality == b.mesh_quality);
  CHECK(a.surface_area == b.surface_area);
  CHECK(a.surface_volume == b.surface_volume);
  CHECK(a.surface_checksum == b.surface_checksum);
  REQUIRE(a.cost.size() == b.cost.size());
  for (const auto& [stage, cost] : a.cost) {
    CHECK(b.cost.at(stage).cpu_s == cost.cpu_s);
    CHECK(b.cost.at(stage).wall_s == cost.wall_s);
  }
  CHECK(a.tools == b.tools);
  CHECK(a.finished == b.finished);
}

CaseRecord distinct_record() {
  CaseRecord r = sample::record("cone_incidence-030", dragcore::Cone{.diameter = 0.7, .apex_angle = 0.5},
                                {.incidence = 0.3, .yaw = -0.2, .roll = 1.1});
  r.load_last.force_viscous *= 1.01;
  r.load_last.moment_pressure += Eigen::Vector3d(1e-17, -2.0, 3e8);
  r.u_null << 1, 2, 3, 4, 5, 6e-9;
  r.u_stated << 6, 5, 4, 3, 2, 1e-9;
  r.known = {true, false, true, true, false, false};
  r.held_out = true;
  r.reason = "commas, \"quotes\", ünïcode and\nlines";
  return r;
}

/// The half of a record's surface with y >= 0, as a half model keeps it.
CaseRecord halved(CaseRecord record, int axis) {
  case_record::SurfaceSample half;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < record.surface.centre.cols(); ++i)
    if (record.surface.centre(axis, i) >= 0.0) kept.push_back(i);
  half.centre = record.surface.centre(Eigen::all, kept);
  half.area_vector = record.surface.area_vector(Eigen::all, kept);
  half.pressure_coefficient = record.surface.pressure_coefficient(kept);
  half.friction_coefficient = record.surface.friction_coefficient(Eigen::all, kept);
  record.surface = half;
  record.half_model = true;
  return record;
}

}  // namespace

TEST_CASE("a run comes back from its file as it was, surface included", "[compare][store][invariance]") {
  const sample::Folder folder;
  const CaseRecord record = distinct_record();
  compare::write_run(folder / "run.h5", record);
  const CaseRecord back = compare::read_run(folder / "run.h5");
  check_equal(back, record);
  CHECK(back.surface.centre == record.surface.centre);
  CHECK(back.surface.area_vector == record.surface.area_vector);
  CHECK(back.surface.pressure_coefficient == record.surface.pressure_coefficient);
  CHECK(back.surface.friction_coefficient == record.surface.friction_coefficient);
}

TEST_CASE("a run without a surface, and of a failed case, comes back too", "[compare][store][hard]") {
  const sample::Folder folder;
  CaseRecord record = distinct_record();
  record.status = case_record::Status::failed;
  record.surface = {};
  record.attempts.clear();
  record.cost.clear();
  record.tools.clear();
  record.mesh_quality.clear();
  compare::write_run(folder / "run.h5", record);
  check_equal(compare::read_run(folder / "run.h5"), record);
}

TEST_CASE("references come back as they were, in order of name, with patches for surfaces", "[compare][store][invariance]") {
  const sample::Folder folder;
  auto records = sample::quick_tier();
  records.push_back(distinct_record());
  records.push_back(sample::record("box", dragcore::Box{.length = 2.0}, {}));
  std::reverse(records.begin(), records.end());
  const compare::Reference reference = compare::merged({}, records);
  REQUIRE(compare::write_reference(folder / "reference.h5", reference, "abc"));
  const compare::Reference back = compare::read_reference(folder / "reference.h5");
  REQUIRE(back.cases.size() == records.size());
  for (std::size_t i = 0; i < back.cases.size(); ++i) {
    check_equal(back.cases[i], reference.cases[i]);
    if (i > 0) CHECK(back.cases[i - 1].name < back.cases[i].name);
    CHECK(back.cases[i].surface.centre.cols() == 0);
    REQUIRE(back.patches[i].size() == reference.patches[i].size());
    for (std::size_t k = 0; k < back.patches[i].size(); ++k) {
      const auto &a = back.patches[i][k], &b = reference.patches[i][k];
      CHECK(a.name == b.name);
      CHECK(a.area == b.area);
      CHECK(a.centroid == b.centroid);
      CHECK(a.area_vector == b.area_vector);
      CHECK(a.pressure_coefficient == b.pressure_coefficient);
      CHECK(a.friction_coefficient == b.friction_coefficient);
      CHECK(a.pressure_moment == b.pressure_moment);
      CHECK(a.pressure_force == b.pressure_force);
    }
  }
}

TEST_CASE("equal references leave the file untouched, and equal runs make equal bytes", "[compare][store][invariance]") {
  const sample::Folder folder;
  const auto records = sample::quick_tier();
  const compare::Reference reference = compare::merged({}, records);
  REQUIRE(compare::write_reference(folder / "reference.h5", reference, "abc"));
  const std::string before = bytes(folder / "reference.h5");
  // What was read and merged again is the same to the last bit, whatever the revision of the program.
  const compare::Reference again = compare::merged(compare::read_reference(folder / "reference.h5"), records);
  CHECK_FALSE(compare::write_reference(folder / "reference.h5", again, "def"));
  CHECK((bytes(folder / "reference.h5") == before));  // as one value: a failure should not print the file
  compare::write_run(folder / "a.h5", records[0]);
  compare::write_run(folder / "b.h5", records[0]);
  CHECK((bytes(folder / "a.h5") == bytes(folder / "b.h5")));  // as one value: a failure should not print the file
}

TEST_CASE("merging keeps other rows, replaces those of the same name and never a good row by a failure of the same key",
          "[compare][store]") {
  auto records = sample::quick_tier();
  compare::Reference reference = compare::merged({}, {records[0], records[1]});
  CaseRecord changed = records[1];
  changed.key = std::string(64, 'b');
  changed.cells = 77;
  reference = compare::merged(reference, {changed, records[2]});
  REQUIRE(reference.cases.size() == 3);
  const auto row = [&](const std::string& name) {
    return *std::find_if(reference.cases.begin(), reference.cases.end(), [&](const CaseRecord& r) { return r.name == name; });
  };
  CHECK(row(records[0].name).key == records[0].key);
  CHECK(row(changed.name).cells == 77);

  CaseRecord failure = changed;
  failure.status = case_record::Status::timed_out;
  reference = compare::merged(reference, {failure});
  CHECK(row(changed.name).status == case_record::Status::steady);
  failure.key = std::string(64, 'c');  // another recipe: what it gives counts, even if that is a failure
  reference = compare::merged(reference, {failure});
  CHECK(row(changed.name).status == case_record::Status::timed_out);
}

TEST_CASE("of two recipes of a case in one cache the later one counts", "[compare][store]") {
  CaseRecord early = sample::quick_tier()[0], late = early;
  early.key = std::string(64, '1');
  late.key = std::string(64, '2');
  late.finished = "2026-01-03T00:00:00Z";
  CHECK(compare::merged({}, {early, late}).cases.at(0).key == late.key);
  CHECK(compare::merged({}, {late, early}).cases.at(0).key == late.key);
}

TEST_CASE("a file of 200 cases stays below 2 MB", "[compare][store][limit]") {
  const sample::Folder folder;
  std::vector<CaseRecord> records;
  for (int i = 0; i < 200; ++i) {
    // Cones have the most patches; a tenth of a degree makes all values differ.
    records.push_back(sample::record("cone_" + std::to_string(i), dragcore::Cone{}, {.incidence = 0.1 * i * sample::deg}));
    records.back().description = std::string(1500, 'd') + std::to_string(i);
  }
  compare::write_reference(folder / "reference.h5", compare::merged({}, records), "abc");
  CHECK(std::filesystem::file_size(folder / "reference.h5") < 2'000'000);
}

TEST_CASE("patches of a box are its six faces with their own pressures", "[compare][store][analytic]") {
  const CaseRecord record = sample::record("box", dragcore::Box{.length = 2.0, .width = 1.0, .height = 0.5}, {.yaw = 30 * sample::deg});
  const auto patches = compare::patch_means(record);
  REQUIRE(patches.size() == 6);
  const auto patch = [&](const std::string& name) {
    const auto found = std::find_if(patches.begin(), patches.end(), [&](const auto& p) { return p.name == name; });
    REQUIRE(found != patches.end());
    return *found;
  };
  // C_p = 2 c^2 - 0.5 (sample_records.hpp); yaw 30 deg turns the wind in the body frame to (cos 30, -sin 30, 0).
  CHECK(patch("x-").area == Approx(0.5).epsilon(1e-12));
  CHECK(patch("x-").pressure_coefficient == Approx(2.0 * 0.75 - 0.5).epsilon(1e-12));
  CHECK((patch("x-").centroid - Eigen::Vector3d(-1.0, 0.0, 0.0)).norm() < 1e-12);
  CHECK(patch("y+").pressure_coefficient == Approx(2.0 * 0.25 - 0.5).margin(1e-12));
  CHECK(patch("x+").pressure_coefficient == Approx(-0.5).epsilon(1e-12));
  CHECK((patch("z+").area_vector - Eigen::Vector3d(0.0, 0.0, 2.0)).norm() < 1e-12);
  CHECK((patch("z+").pressure_force - Eigen::Vector3d(0.0, 0.0, 0.5 * 2.0)).norm() < 1e-12);  // suction pulls up
  CHECK(patch("z+").pressure_moment.norm() < 1e-12);                                          // constant pressure acts at the centroid
  CHECK((patch("z+").friction_coefficient - 0.01 * Eigen::Vector3d(std::sqrt(0.75), -0.5, 0.0)).norm() < 1e-12);
}

TEST_CASE("patches of a prism are its ends, its base and two slanted sides, however blunt", "[compare][store][analytic]") {
  for (const double apex_angle : {0.5, 1.0, 2.0}) {
    const dragcore::Prism prism{.base = 1.0, .span = 2.0, .apex_angle = apex_angle};
    const auto patches = compare::patch_means(sample::record("prism", prism, {}));
    std::vector<std::string> names;
    for (const auto& patch : patches) names.push_back(patch.name);
    CHECK(names == std::vector<std::string>{"x+", "y+", "y-", "z+", "z-"});
    for (const auto& patch : patches)
      if (patch.name[0] == 'z') CHECK(patch.area == Approx(2.0 * 0.5 / std::sin(0.5 * apex_angle)).epsilon(1e-12));
  }
}

TEST_CASE("the pressure's first moment on a patch sees where the pressure is higher", "[compare][store][sign]") {
  CaseRecord record =
      sample::record("plate", dragcore::Plate{.chord = 2.0, .span = 1.0, .thickness = 0.05}, {.incidence = 90 * sample::deg});
  // Pressure falls linearly along the chord, from the nose: C_p = -x/2 on every face, x in the body frame.
  const Eigen::Matrix3d to_body = record.pose.rotation().transpose();
  record.load_last.force_pressure.setZero();
  const double q = 0.5 * record.density * record.speed * record.speed;
  for (Eigen::Index i = 0; i < record.surface.centre.cols(); ++i) {
    record.surface.pressure_coefficient[i] = -0.5 * (to_body * record.surface.centre.col(i)).x();
    record.load_last.force_pressure -= q * record.surface.pressure_coefficient[i] * record.surface.area_vector.col(i);
  }
  for (const auto& patch : compare::patch_means(record))
    if (patch.name == "z-") {
      CHECK(patch.pressure_moment.x() < 0.0);
      // Integral of -x^2/2 over the face is -(1/2)(8/12) = -1/3; triangles of an eighth of the chord (4 divisions of 2 m) sample x at their
      // centroids and miss their own second moment, 1/36 of each edge squared: at most 2 %.
      CHECK(patch.pressure_moment.x() == Approx(-1.0 / 3.0).epsilon(0.05));
    }
}

TEST_CASE("a half model has the patches of the whole body", "[compare][store][invariance]") {
  for (const int axis : {1, 2}) {
    const dragcore::Pose pose = axis == 1 ? dragcore::Pose{.incidence = 0.4} : dragcore::Pose{.yaw = 0.4};
    for (const dragcore::Shape& shape : {dragcore::Shape(dragcore::Box{}), dragcore::Shape(dragcore::Cone{})}) {
      const CaseRecord whole = sample::record("case", shape, pose);
      const auto expected = compare::patch_means(whole), found = compare::patch_means(halved(whole, axis));
      REQUIRE(found.size() == expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        CHECK(found[i].name == expected[i].name);
        // Triangles need not be mirrored along the diagonals of faces; areas and pressures of flat faces agree all the same.
        CHECK(found[i].area == Approx(expected[i].area).epsilon(1e-9));
        CHECK(found[i].pressure_coefficient == Approx(expected[i].pressure_coefficient).margin(1e-9));
        CHECK((found[i].pressure_force - expected[i].pressure_force).norm() < 1e-9);
      }
    }
  }
}

TEST_CASE("a half model a few of whose faces reach over its symmetry plane is still that half", "[compare][store][regression]") {
  // As snappyHexMesh leaves them: hemisphere at 110 degrees, one face of 439 by 0.2 % of the width; tetrahedron, three by 3 %.
  CaseRecord half = halved(sample::record("case", dragcore::Cone{}, {.incidence = 0.4}), 1);
  const std::size_t patches = compare::patch_means(half).size();
  Eigen::Index nearest;
  half.surface.centre.row(1).minCoeff(&nearest);
  const double width = half.surface.centre.row(1).maxCoeff();
  half.surface.centre(1, nearest) = -0.03 * width;
  CHECK(compare::patch_means(half).size() == patches);
  half.surface.centre(1, nearest) = -0.1 * width;
  half.surface.centre(2, nearest) = -0.1 * width;
  CHECK_THROWS_WITH(compare::patch_means(half), Contains("both sides"));
}

TEST_CASE("pressures that do not add up to the force are refused", "[compare][store][regression]") {
  CaseRecord record = sample::quick_tier()[0];
  record.load_last.force_pressure.z() += 0.002 * std::max(record.load_last.force_pressure.norm(), 0.1);
  CHECK_THROWS_WITH(compare::merged({}, {record}), Contains(record.name) && Contains("add up"));
  record = sample::quick_tier()[3];
  record.surface.pressure_coefficient[5] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(compare::merged({}, {record}), Contains("add up"));
  record = sample::quick_tier()[3];
  record.half_model = true;  // but the sample is of the whole body
  CHECK_THROWS_WITH(compare::merged({}, {record}), Contains("both sides"));
}

TEST_CASE("a number that is not finite never enters the store", "[compare][store][hard]") {
  const sample::Folder folder;
  CaseRecord record = distinct_record();
  record.load.force_viscous.y() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(compare::write_run(folder / "run.h5", record), Contains(record.name) && Contains("force_viscous"));
  CHECK_FALSE(std::filesystem::exists(folder / "run.h5"));
  record.status = case_record::Status::diverged;
  compare::write_run(folder / "run.h5", record);
  CHECK(compare::read_run(folder / "run.h5").load.force_viscous.y() == 0.0);
}

TEST_CASE("a truncated file is named, and neither read nor overwritten", "[compare][store][hard]") {
  const sample::Folder folder;
  const compare::Reference reference = compare::merged({}, sample::quick_tier());
  compare::write_reference(folder / "reference.h5", reference, "abc");
  const auto size = std::filesystem::file_size(folder / "reference.h5");
  for (const auto cut : {size / 2, size - 1, std::uintmax_t{100}, std::uintmax_t{0}}) {
    std::filesystem::resize_file(folder / "reference.h5", cut);
    const std::string before = bytes(folder / "reference.h5");
    CHECK_THROWS_WITH(compare::read_reference(folder / "reference.h5"), Contains("reference.h5") && Contains("restore"));
    CHECK_THROWS_WITH(compare::write_reference(folder / "reference.h5", reference, "abc"), Contains("reference.h5"));
    CHECK((bytes(folder / "reference.h5") == before));  // as one value: a failure should not print the file
  }
}

TEST_CASE("a file whose values were changed after it was written is refused", "[compare][store][hard]") {
  const sample::Folder folder;
  const compare::Reference reference = compare::merged({}, sample::quick_tier());
  compare::write_reference(folder / "reference.h5", reference, "abc");
  const hid_t file = H5Fopen((folder / "reference.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT),
              column = H5Dopen2(file, "cases/density", H5P_DEFAULT);
  const std::vector<double> denser(reference.cases.size(), 2.0);
  REQUIRE(H5Dwrite(column, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, denser.data()) >= 0);
  H5Dclose(column);
  H5Fclose(file);
  CHECK_THROWS_WITH(compare::read_reference(folder / "reference.h5"), Contains("reference.h5") && Contains("content_sha256"));
}

TEST_CASE("files of others, and of the other kind, are refused by name", "[compare][store][hard]") {
  const sample::Folder folder;
  std::ofstream(folder / "text.h5") << "not HDF5";
  CHECK_THROWS_WITH(compare::read_run(folder / "text.h5"), Contains("text.h5") && Contains("not an HDF5 file"));
  compare::hdf5::write_file(folder / "foreign.h5", "", "", [](const compare::hdf5::Handle&) {});
  CHECK_THROWS_WITH(compare::read_reference(folder / "foreign.h5"), Contains("foreign.h5") && Contains("no schema of this program"));
  compare::write_run(folder / "run.h5", sample::quick_tier()[0]);
  CHECK_THROWS_WITH(compare::read_reference(folder / "run.h5"), Contains("dragval run"));
  CHECK_THROWS_WITH(compare::read_reference(folder / "absent.h5"), Contains("absent.h5") && Contains("does not exist"));
}

TEST_CASE("a newer major schema is refused, a newer minor one read", "[compare][store][hard]") {
  const sample::Folder folder;
  compare::hdf5::write_file(folder / "newer.h5", "dragval reference", "2.0", [](const compare::hdf5::Handle&) {});
  CHECK_THROWS_WITH(compare::read_reference(folder / "newer.h5"), Contains("2.0") && Contains("newer dragval"));
  compare::hdf5::write_file(folder / "minor.h5", "dragval reference", "1.9", [](const compare::hdf5::Handle&) {});
  // It has no tables, which is found out only after its version was accepted.
  CHECK_THROWS_WITH(compare::read_reference(folder / "minor.h5"), Contains("damaged"));
}

TEST_CASE("threads may write runs at the same time", "[compare][store][hard]") {
  const sample::Folder folder;
  const auto records = sample::quick_tier();
  std::vector<std::jthread> threads;
  for (std::size_t i = 0; i < records.size(); ++i)
    threads.emplace_back([&, i] { compare::write_run(folder / (std::to_string(i) + ".h5"), records[i]); });
  threads.clear();
  const auto back = compare::read_runs(folder / "");
  REQUIRE(back.size() == records.size());
  for (std::size_t i = 1; i < back.size(); ++i) CHECK(back[i - 1].name < back[i].name);
}

TEST_CASE("leftovers of a killed writer are not read", "[compare][store][hard]") {
  const sample::Folder folder;
  compare::write_run(folder / "a.h5", sample::quick_tier()[0]);
  std::ofstream(folder / "b.h5.partial-123") << "half a file";
  CHECK(compare::read_runs(folder / "").size() == 1);
  CHECK(compare::read_runs(folder / "no such folder").empty());
}

TEST_CASE("a body of triangles comes back from the store whole, each mesh kept once", "[compare][store]") {
  const sample::Folder folder;
  const auto tent = [](double height) {
    return dragcore::mesh_body(
        "tent", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.2, height}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}}, 0.7, 1.3);
  };
  std::vector<CaseRecord> records = {sample::record("tent_incidence-000", tent(1.0), {}),
                                     sample::record("tent_incidence-030", tent(1.0), {.incidence = 0.5}),
                                     sample::record("tent_yaw-010", tent(2.0), {.yaw = 0.2}), distinct_record()};
  compare::Reference reference = compare::merged({}, records);
  compare::write_reference(folder / "reference.h5", reference, "abc");
  const compare::Reference again = compare::read_reference(folder / "reference.h5");
  REQUIRE(again.cases.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(dragcore::kind(again.cases[i].shape) == dragcore::kind(reference.cases[i].shape));
    // The prediction needs nothing but the file.
    const auto before = compare::predict(reference.cases[i], {}).total(), after = compare::predict(again.cases[i], {}).total();
    CHECK(before.force.isApprox(after.force, 1e-10));  // poses are stored in degrees, rounded to 1e-9
    CHECK((before.torque - after.torque).norm() < 1e-10 * before.force.norm());
  }
  const auto& body = std::get<dragcore::MeshBody>(again.cases[1].shape);
  CHECK(body.mesh->vertices == std::get<dragcore::MeshBody>(reference.cases[1].shape).mesh->vertices);
  CHECK(body.measured.reference_area == 0.7);
  CHECK(body.measured.reference_length == 1.3);
  // The same name, another mesh: told apart by its triangles.
  CHECK(again.cases[2].surface_checksum != again.cases[3].surface_checksum);
  {
    const std::scoped_lock lock(compare::hdf5::library_mutex());
    const auto file = compare::hdf5::open_file(folder / "reference.h5", "dragval reference", 1);
    CHECK(compare::hdf5::members(compare::hdf5::open_group(file, "meshes")).size() == 2);
  }
  CHECK_FALSE(compare::write_reference(folder / "reference.h5", again, "def"));  // the same rows

  compare::write_run(folder / "run.h5", reference.cases[1]);
  CHECK(dragcore::parameters(compare::read_run(folder / "run.h5").shape) == dragcore::parameters(reference.cases[1].shape));
}

// Finer meshes than these would let it fade: docs/cfd.md, "Friction along the normal". What the test holds is that it is there, on bodies
// whose patches are flat, so that nobody takes the stored friction for shear alone, and that the total converges all the same.
TEST_CASE("the stored friction of slow flow has a part along the normal, and the total converges with it", "[compare][store]") {
  const compare::Reference reference = compare::read_reference(SOURCE_FOLDER "/results/reference.h5");
  struct Level {
    double drag, along_normal, cells;
  };
  std::vector<Level> levels;
  for (std::size_t i = 0; i < reference.cases.size(); ++i) {
    const compare::CaseRecord& record = reference.cases[i];
    if (!record.name.starts_with("cube_incidence-000_re-1e2-laminar_")) continue;
    Eigen::Vector3d along_normal = Eigen::Vector3d::Zero();
    for (const compare::PatchMean& patch : reference.patches[i]) {
      const Eigen::Vector3d n = patch.area_vector.normalized();
      along_normal += patch.area * n * n.dot(patch.friction_coefficient);
    }
    // The pose is upright: body and wind frame are one.
    levels.push_back({2.0 * record.load.force().x(), along_normal.x(), static_cast<double>(record.cells)});
  }
  REQUIRE(levels.size() == 4);
  std::sort(levels.begin(), levels.end(), [](const Level& a, const Level& b) { return a.cells < b.cells; });
  for (const Level& level : levels) {
    CHECK(level.along_normal > 0.03 * level.drag);
    CHECK(level.along_normal < 0.12 * level.drag);
  }
  for (std::size_t i = 0; i + 2 < levels.size(); ++i) {
    CHECK(levels[i].drag > levels[i + 1].drag);
    // The ratio of cell sizes is 1.4: the differences fall faster than the first power of the size.
    CHECK(levels[i].drag - levels[i + 1].drag > 1.4 * (levels[i + 1].drag - levels[i + 2].drag));
  }
}
