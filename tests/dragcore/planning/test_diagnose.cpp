#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/diagnose.hpp>
#include <dragcore/shapes.hpp>

using namespace dragcore;
using Catch::Matchers::Contains;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// The one warning there must be.
std::string only(Mistake mistake, const std::vector<Warning>& found) {
  REQUIRE(found.size() == 1);
  CHECK(found.front().mistake == mistake);
  return found.front().text;
}

const Surface& box() {
  static const Surface surface(triangulate(Box{1.2, 0.8, 0.4}, 2));
  return surface;
}

const Motion flight{.wind = {3, 0, 0}, .velocity = {8, 2, -1}, .angular_velocity = {1, 2, 3}};

const Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();

Motion in_body(const Matrix3d& to_body) { return {.wind = to_body * flight.wind, .velocity = to_body * flight.velocity}; }

}  // namespace

TEST_CASE("nothing is said about bodies in ordinary flight", "[diagnose]") {
  CHECK(diagnose(box(), flight).empty());
  CHECK(diagnose(box(), {}).empty());
  CHECK(diagnose(box(), {.velocity = {2, 0, 0}}, {.density = 998.0}).empty());
  CHECK(diagnose(Surface(triangulate(Plate{0.297, 0.21, 0.0}, 1)), {.velocity = {5, 0, 1}, .angular_velocity = {30, 30, 0}}).empty());
  CHECK(diagnose(Surface(triangulate(Sphere{0.04}, 4)), {.velocity = {70, 0, 0}, .angular_velocity = {0, 300, 0}}).empty());  // a golf ball
  CHECK(diagnose(Surface(triangulate(Cylinder{6.0, 40.0}, 4)), {.velocity = {20, 0, 0}}).empty());                            // a hull
  CHECK(diagnose(box(), in_body(turn.transpose()), {}, {.to_world = turn, .velocity = flight.velocity, .wind = flight.wind}).empty());
  // A velocity in floats, as engines have it.
  CHECK(
      diagnose(box(), in_body(turn.transpose()), {}, {.to_world = turn, .velocity = flight.velocity.cast<float>().cast<double>()}).empty());
}

TEST_CASE("a mesh in millimetres is noticed by its extents, and one scaled twice", "[diagnose]") {
  const auto scaled = [](double factor) {
    return Surface(transformed(triangulate(Box{1.2, 0.8, 0.4}, 1), factor * Matrix3d::Identity(), Vector3d::Zero()));
  };
  CHECK_THAT(only(Mistake::unit_of_length, diagnose(scaled(1000), {})), Contains("1200 x 800 x 400 m") && Contains("0.001"));
  CHECK_THAT(only(Mistake::unit_of_length, diagnose(scaled(100), {})), Contains("120 x 80 x 40 m"));
  CHECK_THAT(only(Mistake::unit_of_length, diagnose(scaled(0.0005), {})), Contains("applied twice"));
}

TEST_CASE("a reference point that cannot be the centre of mass is noticed", "[diagnose]") {
  Motion motion = flight;
  motion.reference_point = {5, 0, 0};
  CHECK_THAT(only(Mistake::reference_point, diagnose(box(), motion)), Contains("(5, 0, 0)") && Contains("4.4 m outside"));
  motion.reference_point = {0.5, -0.3, 0.1};
  CHECK(diagnose(box(), motion).empty());
  // A kite's bridle hangs close to it.
  const Surface kite(triangulate(Plate{1.0, 0.8, 0.0}, 1));
  motion.reference_point = {0, 0, 0.05};
  CHECK(diagnose(kite, motion).empty());
}

TEST_CASE("speeds where air is compressed are noticed, of travel, spin and wind", "[diagnose]") {
  CHECK_THAT(only(Mistake::speed, diagnose(box(), {.wind = {-1000, 0, 0}})), Contains("1000 m/s") && Contains("Mach 2.941"));
  CHECK_THAT(only(Mistake::speed, diagnose(box(), {.angular_velocity = {0, 0, 360}})), Contains("rad/s"));
  const std::vector<Vector3d> gusts(static_cast<std::size_t>(box().size()), Vector3d(0, 150, 0));
  CHECK_THAT(only(Mistake::speed, diagnose(box(), {.triangle_wind = gusts})), Contains("150 m/s"));
  CHECK(diagnose(box(), {.wind = {99, 0, 0}}).empty());
}

TEST_CASE("densities of nothing known are noticed", "[diagnose]") {
  for (const double density : {0.0, -1.2, 0.001225, 100.0, 7850.0})
    CHECK_THAT(only(Mistake::density, diagnose(box(), flight, {.density = density})), Contains("1.225"));
  CHECK(diagnose(box(), flight, {.density = 0.018}).empty());  // air at 30 km
}

TEST_CASE("what is not finite is said, and nothing is made of it", "[diagnose][hard]") {
  CHECK_THAT(only(Mistake::not_finite, diagnose(box(), {.velocity = {NAN, 0, 0}})), Contains("not a number"));
  only(Mistake::not_finite, diagnose(box(), {.reference_point = {0, INFINITY, 0}}));
  only(Mistake::not_finite, diagnose(box(), flight, {.density = NAN}));
}

TEST_CASE("a surface without area is noticed", "[diagnose][hard]") {
  CHECK_THAT(only(Mistake::empty_surface, diagnose(Surface(TriangleMesh{}), flight)), Contains("no triangle"));
}

TEST_CASE("a transposed matrix is told from a wrong one and from none", "[diagnose][sign]") {
  // The motion turned with to_world where to_body was due.
  CHECK_THAT(only(Mistake::frame, diagnose(box(), in_body(turn), {}, {.to_world = turn, .velocity = flight.velocity})),
             Contains("motion.velocity") && Contains("transposed"));
  CHECK_THAT(only(Mistake::frame, diagnose(box(), in_body(turn), {}, {.to_world = turn, .wind = flight.wind})), Contains("motion.wind"));
  // The world's velocity handed over as it is.
  CHECK_THAT(only(Mistake::frame, diagnose(box(), flight, {}, {.to_world = turn, .velocity = flight.velocity})), Contains("turn it into"));
  // Where both ways give the same there is nothing to notice.
  CHECK(diagnose(box(), flight, {}, {.velocity = flight.velocity}).empty());
  CHECK(diagnose(box(), {}, {}, {.to_world = turn, .velocity = Vector3d(0, 0, 0)}).empty());
}

TEST_CASE("a pose matrix that is no rotation is noticed, with what is wrong about it", "[diagnose]") {
  const auto of = [](const Matrix3d& to_world) { return only(Mistake::rotation, diagnose(box(), flight, {}, {.to_world = to_world})); };
  CHECK_THAT(of(100.0 * turn), Contains("(100, 100, 100)"));
  CHECK_THAT(of(turn * Vector3d(1, -1, 1).asDiagonal()), Contains("mirrors") && Contains("left-handed"));
  CHECK_THAT(of(turn.cast<float>().cast<double>()), Contains("single precision"));
  CHECK_THAT(of(Matrix3d::Zero()), Contains("not a rotation"));
  CHECK_THAT(of(Matrix3d::Constant(NAN)), Contains("not a rotation"));
}

TEST_CASE("several mistakes are all told, in order", "[diagnose]") {
  Motion motion{.wind = {300, 0, 0}};
  motion.reference_point = {0, 0, 9};
  const std::vector<Warning> found = diagnose(box(), motion, {.density = 50}, {.to_world = 2.0 * turn});
  REQUIRE(found.size() == 4);
  CHECK(found[0].mistake == Mistake::reference_point);
  CHECK(found[1].mistake == Mistake::speed);
  CHECK(found[2].mistake == Mistake::density);
  CHECK(found[3].mistake == Mistake::rotation);
}
