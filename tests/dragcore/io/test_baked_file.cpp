#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <dragcore/baked_file.hpp>
#include <fstream>
#include <iterator>
#include <limits>

#include "tests/support/folder.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Contains;
using support::Folder;

namespace {

BakedBody baked_cone(bool spins = true) {
  const Surface surface(transformed(triangulate(Cone{}, 3), Eigen::Matrix3d::Identity(), {0.2, -0.1, 0.4}));
  Model model = model_for(surface);
  if (!spins) model.effects = model.effects.without(Effect::spin);
  return bake(surface, model, {.rms_error = 0.05});
}

std::string bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("a baked body comes back from its file to the bit", "[bake][io]") {
  const Folder folder;
  for (const bool spins : {true, false}) {
    const BakedBody body = baked_cone(spins);
    write_baked(folder.path / "cone.h5", body);
    const BakedBody read = read_baked(folder.path / "cone.h5");
    CHECK(read.steady.values == body.steady.values);
    CHECK(read.rate.values == body.rate.values);
    CHECK(read.tumble.values == body.tumble.values);
    CHECK(read.steady.frequency == body.steady.frequency);
    CHECK((read.centre == body.centre && read.area == body.area && read.length == body.length && read.rms_force == body.rms_force));
    CHECK((read.model == body.model && read.surface_hash == body.surface_hash && read.model_hash == body.model_hash));
    CHECK((read.error.worst_torque == body.error.worst_torque && read.error.rms_force == body.error.rms_force));
    CHECK(read.spin_error[2].rms_torque == body.spin_error[2].rms_torque);
    const Motion motion{.wind = {3, 1, -2}, .angular_velocity = {1, 2, 3}};
    CHECK(wrench(read, motion, {}).force == wrench(body, motion, {}).force);
    const std::string first = bytes(folder.path / "cone.h5");
    write_baked(folder.path / "again.h5", body);
    CHECK(bytes(folder.path / "again.h5") == first);  // same contents, same bytes
  }
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path), {}) == 2);  // nothing partial is left
}

TEST_CASE("a file that is no baked body is refused by name", "[bake][io][hard]") {
  const Folder folder;
  CHECK_THROWS_WITH(read_baked(folder.path / "none.h5"), Contains("none.h5") && Contains("no such file"));
  CHECK_THROWS_WITH(read_baked(folder.write("text.h5", "solid cone")), Contains("not an HDF5 file"));
  CHECK_THROWS_WITH(write_baked(folder.path / "no" / "such.h5", baked_cone()), Contains("folder exists"));
  write_baked(folder.path / "good.h5", baked_cone());
  const std::string good = bytes(folder.path / "good.h5");
  CHECK_THROWS_WITH(read_baked(folder.write("cut.h5", good.substr(0, good.size() / 2))), Contains("cut.h5"));
  // Any byte that changes anything is found, or changes nothing: checksums.
  const BakedBody body = baked_cone();
  for (std::size_t at = 11; at < good.size(); at += 997) {
    std::string damaged = good;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    INFO("byte " << at);
    const std::filesystem::path file = folder.write("damaged.h5", damaged);
    try {
      const BakedBody read = read_baked(file);
      CHECK(read.steady.values == body.steady.values);
    } catch (const std::runtime_error& fault) {
      CHECK_THAT(fault.what(), Contains("damaged.h5"));
    }
  }
  // A value that is no number is found when it is read, not when a body flies away.
  BakedBody wrong = body;
  wrong.tumble.values[17] = std::numeric_limits<float>::quiet_NaN();
  write_baked(folder.path / "nan.h5", wrong);
  CHECK_THROWS_WITH(read_baked(folder.path / "nan.h5"), Contains("dataset tumble") && Contains("not finite"));
  wrong = body;
  wrong.rate.columns = 2;  // a map of another shape
  wrong.rate.values.resize(wrong.rate.values.size() / 3 * 2);
  write_baked(folder.path / "shape.h5", wrong);
  CHECK_THROWS_WITH(read_baked(folder.path / "shape.h5"), Contains("dataset rate has shape [7, 7, 2, 8]"));
  wrong = body;
  wrong.length = 0.0;
  write_baked(folder.path / "length.h5", wrong);
  CHECK_THROWS_WITH(read_baked(folder.path / "length.h5"), Contains("greater than 0"));
}

TEST_CASE("a C compiler takes the header, and its function is wrench()", "[bake][io]") {
  const Folder folder;
  for (const bool spins : {true, false}) {
    const BakedBody body = baked_cone(spins);
    write_c_header(folder.path / "cone.h", body, "AREA_51");
    const std::filesystem::path program = folder.write("main.c", R"(#include "cone.h"
#include <stdio.h>
int main(void) {
  double u[3], w[3], density, f[3], t[3];
  while (scanf("%lf %lf %lf %lf %lf %lf %lf", u, u + 1, u + 2, w, w + 1, w + 2, &density) == 7) {
    AREA_51_wrench(u, w, density, f, t);
    printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", f[0], f[1], f[2], t[0], t[1], t[2]);
  }
  return 0;
}
)");
    const auto quoted = [](const std::filesystem::path& path) { return "'" + path.string() + "'"; };
    const std::filesystem::path binary = folder.path / "main", in = folder.path / "in.txt", out = folder.path / "out.txt";
    REQUIRE(std::system((std::string(C_COMPILER) + " -std=c99 -pedantic -Wall -Wextra -Werror -o " + quoted(binary) + " " +
                         quoted(program) + " -lm")
                            .c_str()) == 0);
    zoo::Random random(4);
    std::vector<Motion> motions;
    {
      std::ofstream numbers(in);
      numbers.precision(17);
      for (int k = 0; k < 500; ++k) {
        Motion motion{.wind = random.vector(3.0), .angular_velocity = random.vector(3.0), .reference_point = body.centre};
        if (k % 5 == 0) motion.angular_velocity.setZero();
        if (k % 5 == 1) motion.wind.setZero();
        if (k % 5 == 2) motion.wind[k % 3] = 0.0;
        if (k == 10) motion = {.reference_point = body.centre};
        motions.push_back(motion);
        numbers << motion.wind.transpose() << " " << motion.angular_velocity.transpose() << " 1.2\n";
      }
    }
    REQUIRE(std::system((quoted(binary) + " < " + quoted(in) + " > " + quoted(out)).c_str()) == 0);
    std::ifstream results(out);
    for (const Motion& motion : motions) {
      Wrench found;
      for (Eigen::Vector3d* vector : {&found.force, &found.torque}) REQUIRE(results >> (*vector)[0] >> (*vector)[1] >> (*vector)[2]);
      const Wrench ours = wrench(body, motion, {.density = 1.2});
      // The header sums in double what the library sums in float.
      const double unit = 0.6 * body.area * (motion.wind.squaredNorm() + std::pow(body.length, 2) * motion.angular_velocity.squaredNorm());
      CHECK((found.force - ours.force).norm() <= 1e-6 * unit);
      CHECK((found.torque - ours.torque).norm() <= 1e-6 * unit * body.length);
    }
  }
  for (const char* name : {"", "7up", "a-b", "a b"})
    CHECK_THROWS_WITH(write_c_header(folder.path / "x.h", baked_cone(), name), Contains("letters"));
  CHECK_THROWS_WITH(write_c_header(folder.path / "no" / "x.h", baked_cone(), "x"), Contains("cannot be written"));
  CHECK_FALSE(std::filesystem::exists(folder.path / "x.h"));
}
