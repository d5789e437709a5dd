#include <catch2/catch.hpp>

#include "cfd_cases/flow_case/force_history.hpp"
#include "tests/cfd_cases/temporary_folder.hpp"

using namespace cfd_cases;
using Catch::Matchers::Contains;
using Eigen::Vector3d;

namespace {

const std::string kHeader =
    "# Force\n# CofR : (0 0 0)\n#\n# Time \t(total_x total_y total_z)\t(pressure_x pressure_y pressure_z)\t(viscous_x viscous_y "
    "viscous_z)\n";

std::string row(double time, double drag) {
  return std::to_string(time) + "\t(" + std::to_string(drag + 0.5) + " 2 3)\t(" + std::to_string(drag) + " 2 3)\t(0.5 0 0)\n";
}

}  // namespace

TEST_CASE("force and moment files are read by their header", "[cfd_cases][forces][analytic]") {
  const auto samples = parse_forces(kHeader + row(1, 1.0) + row(2, 1.5), kHeader + row(1, 7.0) + row(2, 8.0));
  REQUIRE(samples.size() == 2);
  CHECK(samples[1].time == 2.0);
  CHECK(samples[1].load.force_pressure == Vector3d(1.5, 2.0, 3.0));
  CHECK(samples[1].load.force_viscous == Vector3d(0.5, 0.0, 0.0));
  CHECK(samples[1].load.moment_pressure == Vector3d(8.0, 2.0, 3.0));
  CHECK(samples[1].load.force() == Vector3d(2.0, 2.0, 3.0));
}

TEST_CASE("a line that is still being written is left out, and so is a row that only one file has", "[cfd_cases][forces][hard]") {
  const std::string unfinished = row(3, 9.0);
  const auto samples = parse_forces(kHeader + row(1, 1.0) + row(2, 2.0) + unfinished.substr(0, 20), kHeader + row(1, 1.0));
  REQUIRE(samples.size() == 1);
  CHECK(parse_forces("", "").empty());
}

TEST_CASE("files that are not what they should be are refused", "[cfd_cases][forces][hard]") {
  const std::string good = kHeader + row(1, 1.0);
  CHECK_THROWS_WITH(parse_forces(kHeader + "1 (9 2 3) (1 2 3) (0.5 0 0)\n", good), Contains("total is not pressure + viscous"));
  CHECK_THROWS_WITH(parse_forces("# Time (pressure) (viscous)\n" + row(1, 1.0), good), Contains("no header"));
  CHECK_THROWS_WITH(parse_forces(kHeader + "1 (1 2 3) (1 2 3)\n", good), Contains("needed 10"));
  CHECK_THROWS_WITH(parse_forces(good, kHeader + row(2, 1.0)), Contains("differ"));
}

TEST_CASE("a restart replaces the iterations it repeats", "[cfd_cases][forces]") {
  const TemporaryFolder folder;
  for (const char* file : {"force.dat", "moment.dat"}) {
    folder.write(std::string("postProcessing/forces/0/") + file, kHeader + row(1, 1.0) + row(2, 2.0) + row(3, 3.0) + row(4, 4.0));
    folder.write(std::string("postProcessing/forces/2/") + file, kHeader + row(3, 30.0) + row(4, 40.0) + row(5, 50.0));
  }
  const auto samples = read_forces(folder.path);
  REQUIRE(samples.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) CHECK(samples[i].time == static_cast<double>(i + 1));
  CHECK(samples[1].load.force_pressure.x() == 2.0);
  CHECK(samples[2].load.force_pressure.x() == 30.0);
}

TEST_CASE("a half model counts double in its plane and nothing across it", "[cfd_cases][forces][sign]") {
  const case_record::Load half{{1, 2, 3}, {0.1, 0.2, 0.3}, {4, 5, 6}, {0.4, 0.5, 0.6}};
  const auto y = whole_body(half, Symmetry::plane_y), z = whole_body(half, Symmetry::plane_z), all = whole_body(half, Symmetry::none);
  CHECK(y.force_pressure == Vector3d(2, 0, 6));
  CHECK(y.moment_viscous == Vector3d(0, 1.0, 0));
  CHECK(z.force_viscous == Vector3d(0.2, 0.4, 0));
  CHECK(z.moment_pressure == Vector3d(0, 0, 12));
  CHECK(all.force_pressure == half.force_pressure);
  CHECK(all.moment_pressure == half.moment_pressure);
}
