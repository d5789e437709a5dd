#include <dragcore/dragcore_calibrated_file.h>

#include <catch2/catch.hpp>
#include <dragcore/calibrated_file.hpp>
#include <fstream>
#include <limits>

#include "tests/support/folder.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Contains;

namespace {

CalibratedModel sample() {
  const Surface surface = zoo::surface(Cone{}, 4);
  CalibratedModel made{.model = model_for(surface), .error = {0.03, 0.08, 0.02, 0.05, 0.01, 0.04, 0.02, 12}};
  auto correction = std::make_shared<Correction>();
  correction->map = DirectionMap::zero(4, 1);
  for (int node = 0; node < correction->map.nodes(); ++node)
    correction->map.set(node, 0, 0.01 * node * Eigen::Vector3d(1, -2, 3), Eigen::Vector3d(0.5, 0, 1.0 / (1 + node)));
  correction->body = surface.shape_moments;
  correction->least_reynolds = 8e4, correction->most_reynolds = 1.2e5;
  correction->origin = "12 poses, OpenFOAM 1912";
  made.model.correction = correction;
  made.provenance = {{"method", "k-omega SST"}, {"date", "2026-11-28"}};
  return made;
}

}  // namespace

TEST_CASE("a calibrated model read again is the one that was written, and gives the same forces", "[calibrated_file]") {
  const support::Folder folder;
  CalibratedModel made = sample();
  for (const bool sheets : {false, true}) {
    if (sheets) made.model.sheets = SheetModel{law_for(BodyClass::sheet), class_pillow(BodyClass::sheet)};
    write_calibrated(folder.path / "body.h5", made);
    const CalibratedModel read = read_calibrated(folder.path / "body.h5");
    CHECK(read.model.law == made.model.law);
    CHECK(read.model.pillow == made.model.pillow);
    CHECK(read.model.sheets.has_value() == sheets);
    CHECK(read.model.correction->map.values == made.model.correction->map.values);
    CHECK(read.model.correction->body == made.model.correction->body);
    CHECK(read.model.correction->least_reynolds == 8e4);
    CHECK(read.model.correction->most_reynolds == 1.2e5);
    CHECK(read.model.correction->origin == "12 poses, OpenFOAM 1912");
    CHECK(read.provenance == made.provenance);
    CHECK(read.error.worst_force == 0.08);
    CHECK(read.error.poses == 12);
    CHECK(read.most_mach == 0.3);
    const Surface surface = zoo::surface(Cone{}, 4);
    const Motion motion{.wind = {3, 1, 2}, .angular_velocity = {1, 0, 0}};
    CHECK(wrench(surface, motion, {}, read.model).total().force == wrench(surface, motion, {}, made.model).total().force);
  }
}

TEST_CASE("the C interface reads a calibrated model, which feels what it does in C++", "[calibrated_file]") {
  const support::Folder folder;
  const CalibratedModel made = sample();
  const std::string file = (folder.path / "body.h5").string();
  write_calibrated(file, made);
  dragcore_model model;
  dragcore_correction* correction = nullptr;
  REQUIRE(dragcore_calibrated_read(file.c_str(), &model, &correction) == DRAGCORE_OK);
  CHECK(model.correction == correction);
  const TriangleMesh mesh = triangulate(Cone{}, 4);
  dragcore_surface* surface = nullptr;
  REQUIRE(dragcore_surface_create(mesh.vertices[0].data(), mesh.vertices.size(), mesh.triangles[0].data(), mesh.triangles.size(),
                                  DRAGCORE_ONE_SIDED, &surface) == DRAGCORE_OK);
  dragcore_motion motion{};
  motion.wind[0] = 3.0, motion.wind[1] = 1.0;
  dragcore_wrench found;
  REQUIRE(dragcore_evaluate(surface, &motion, 1.2, &model, &found) == DRAGCORE_OK);
  const Wrench expected = wrench(zoo::surface(Cone{}, 4), {.wind = {3, 1, 0}}, {.density = 1.2}, made.model).total();
  for (int k = 0; k < 3; ++k) CHECK(found.force[k] == expected.force[k]);
  dragcore_surface_destroy(surface);
  dragcore_correction_destroy(correction);
  CHECK(dragcore_calibrated_read("none.h5", &model, &correction) == DRAGCORE_FAILED);
  CHECK(correction == nullptr);
}

TEST_CASE("files that are no calibrated model, damaged or of another version are refused with their name", "[calibrated_file]") {
  const support::Folder folder;
  CHECK_THROWS_WITH(read_calibrated(folder.path / "none.h5"), Contains("none.h5") && Contains("no such file"));
  std::ofstream(folder.path / "text.h5") << "not HDF5 at all, but long enough to look at its first forty-eight bytes";
  CHECK_THROWS_WITH(read_calibrated(folder.path / "text.h5"), Contains("is not an HDF5 file"));
  write_calibrated(folder.path / "body.h5", sample());
  std::ifstream in(folder.path / "body.h5", std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  std::ofstream(folder.path / "short.h5", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  CHECK_THROWS_WITH(read_calibrated(folder.path / "short.h5"), Contains("short.h5"));
  // Every byte matters or none does: whatever is flipped, the reader gives the same numbers or a clear error.
  int refused = 0;
  for (std::size_t at = 0; at < bytes.size(); at += 97) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x20);
    std::ofstream(folder.path / "damaged.h5", std::ios::binary) << damaged;
    try {
      read_calibrated(folder.path / "damaged.h5");
    } catch (const std::runtime_error& fault) {
      ++refused;
      CHECK_THAT(fault.what(), Contains("damaged.h5"));
    }
  }
  CHECK(refused > 10);
  Model plain;
  CHECK_THROWS_WITH(write_calibrated(folder.path / "body.h5", {.model = plain}), Contains("no correction"));
  // What a reader would refuse is not written: of a table with a C_D of 1e300 a model was.
  CalibratedModel made = sample();
  made.error.worst_moment = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(write_calibrated(folder.path / "nan.h5", made), Contains("not finite"));
  CHECK_FALSE(std::filesystem::exists(folder.path / "nan.h5"));
}
