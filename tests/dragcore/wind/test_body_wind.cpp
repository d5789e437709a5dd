#include <catch2/catch.hpp>
#include <dragcore/body_wind.hpp>
#include <dragcore/stepping.hpp>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Solid rotation of the air about the origin of the world, as a grid that trilinear sampling reproduces exactly.
Wind rotating_air(const Vector3d& omega) {
  Grid grid{.points = {2, 2, 2},
            .lower = Vector3d::Constant(-10.0),
            .upper = Vector3d::Constant(10.0),
            .values = Eigen::Matrix3Xd(3, 8),
            .outside = Outside::clamp};
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i)
        grid.values.col((k * 2 + j) * 2 + i) = omega.cross(Vector3d(20.0 * i - 10.0, 20.0 * j - 10.0, 20.0 * k - 10.0));
  return Wind({{.name = "turning", .field = std::make_shared<const GridField>(grid)}});
}

double difference(const Wrench& a, const Wrench& b) { return (a.force - b.force).norm() + (a.torque - b.torque).norm(); }

}  // namespace

TEST_CASE("air that turns about a resting body is a body that turns the other way in resting air", "[body_wind][invariance]") {
  const Vector3d omega(0.3, -1.2, 2.0);
  const Wind wind = rotating_air(omega);
  zoo::Random random(3);
  for (const Shape& shape : {Shape(Box{}), Shape(Plate{.thickness = 0.0}), Shape(Cone{})}) {
    const Surface surface = zoo::surface(shape, 4);
    for (const Model& model : zoo::models()) {
      const BodyPlacement place{random.vector(2.0), random.rotation()};
      Motion turning{.reference_point = random.vector(0.2)};
      turning.angular_velocity = -(place.rotation.transpose() * omega);
      turning.velocity = place.rotation.transpose() * -omega.cross(place.rotation * turning.reference_point + place.position);
      const Wrench expected = wrench(surface, turning, {}, model).total();

      Motion resting{.reference_point = turning.reference_point};
      const BodyWind affine(wind, surface, place, resting.reference_point, WindSampling::affine);
      affine.apply_to(resting);
      // The same numbers but for rounding: the field is affine, so value and gradient are exact.
      CHECK(difference(wrench(surface, resting, {}, model).total(), expected) < 1e-11 * (1.0 + expected.force.norm()));
    }
  }
}

TEST_CASE("values per triangle converge to the affine wind as triangles shrink", "[body_wind][convergence]") {
  const Wind wind = rotating_air({0.0, 0.0, 1.5});
  const BodyPlacement place{{1.0, 0.5, 0.0}, Pose{.incidence = 0.3, .yaw = 0.4}.rotation()};
  const Model model{.law = consistent_law(), .quadrature = Quadrature::six};
  const auto error = [&](int divisions) {
    const Surface surface = zoo::surface(Box{}, divisions);
    Motion affine, sampled;
    const BodyWind a(wind, surface, place, Vector3d::Zero(), WindSampling::affine),
        b(wind, surface, place, Vector3d::Zero(), WindSampling::per_triangle);
    a.apply_to(affine);
    b.apply_to(sampled);
    return difference(wrench(surface, affine, {}, model).total(), wrench(surface, sampled, {}, model).total());
  };
  CHECK(error(16) < 0.01);
  CHECK(error(8) / error(16) > 3.0);  // second order: 4
}

TEST_CASE("every sampling is the uniform wind where the wind is uniform", "[body_wind][limit]") {
  const Wind wind({{.name = "w", .field = UniformField{{3.0, -1.0, 0.5}}}});
  const Surface surface = zoo::surface(Cone{}, 5);
  const BodyPlacement place{{4.0, 0.0, 1.0}, Pose{.incidence = 1.0, .roll = 0.2}.rotation()};
  Motion uniform{.velocity = {0.1, 0.2, 0.3}, .angular_velocity = {1.0, 0.0, 2.0}};
  Motion motion = uniform;
  uniform.wind = place.rotation.transpose() * Vector3d(3.0, -1.0, 0.5);
  const Model model = model_for(surface);
  const Wrench expected = wrench(surface, uniform, {}, model).total();
  for (const WindSampling sampling : {WindSampling::constant, WindSampling::affine, WindSampling::per_triangle}) {
    const BodyWind body_wind(wind, surface, place, motion.reference_point, sampling);
    body_wind.apply_to(motion);
    CHECK(difference(wrench(surface, motion, {}, model).total(), expected) < 1e-13);
  }
  CHECK(BodyWind::within(wind, surface, place, Vector3d::Zero(), 1e-9).sampling() == WindSampling::constant);
}

TEST_CASE("the cheapest sampling within a tolerance is taken, and its wind is within it", "[body_wind][analytic]") {
  const Wind vortex({{.name = "v", .field = VortexField{.circulation = 20.0, .core_radius = 1.0}}});
  const Surface surface = zoo::surface(Box{}, 6);
  WindSampling last = WindSampling::per_triangle;
  for (const double tolerance : {0.01, 0.3, 3.0, 30.0}) {
    const BodyPlacement place{{3.0, 0.0, 0.0}, Matrix3d::Identity()};
    const BodyWind wind = BodyWind::within(vortex, surface, place, Vector3d::Zero(), tolerance);
    CHECK(static_cast<int>(wind.sampling()) <= static_cast<int>(last));  // a wider tolerance never costs more
    last = wind.sampling();
    Motion motion;
    wind.apply_to(motion);
    for (Eigen::Index i = 0; i < surface.size(); ++i) {
      const Vector3d r = surface.centroid.row(i).matrix();
      const Vector3d given = motion.triangle_wind.empty() ? Vector3d(motion.wind + motion.wind_gradient * r)
                                                          : motion.triangle_wind[static_cast<std::size_t>(i)];
      CHECK((given - vortex.velocity(place.position + r)).norm() <= tolerance + 1e-12);
    }
  }
  CHECK(last == WindSampling::constant);
}

TEST_CASE("a step in turning air goes with the whole wrench, and ends in turning with the air", "[body_wind][stepping]") {
  const Vector3d omega(0.0, 0.0, 3.0);
  const Wind wind = rotating_air(omega);
  const Surface surface = zoo::surface(Box{}, 3);
  const Model model{.law = closed_law()};
  const MassProperties body{.mass = 0.02, .inertia = 0.02 / 6 * Matrix3d::Identity()};
  Motion motion;
  for (int step = 0; step < 4000;
       ++step) {  // the body stays at the axis; its attitude does not matter to a field of solid rotation about z
    const BodyWind body_wind(wind, surface, {}, Vector3d::Zero(), WindSampling::affine);
    body_wind.apply_to(motion);
    const Matrix6d s = resistance(surface, motion, {}, model);
    const Vector6d excess = wind_excess(wrench(surface, motion, {}, model).total(), s, motion);
    const Vector6d next = step_secant_implicit(s, body, motion, excess, 0.05);
    motion.velocity = next.head<3>(), motion.angular_velocity = next.tail<3>();
  }
  CHECK(motion.velocity.norm() < 1e-10);
  // Quadratic drag approaches like 1/time: 4000 steps of 0.05 s leave a few per cent of the spin to go.
  CHECK_THAT((motion.angular_velocity - omega).norm() / omega.norm(), WithinAbs(0.0, 0.05));
}

TEST_CASE("a wind of the wrong length, or a frame that is no rotation, is refused", "[body_wind][hard]") {
  const Surface surface = zoo::surface(Box{}, 2);
  const std::vector<Vector3d> few(3, Vector3d::UnitX());
  Motion motion;
  motion.triangle_wind = few;
  CHECK_THROWS_WITH(wrench(surface, motion, {}, {.check = false}), Catch::Contains("= 3, but the surface has"));
  const Wind wind({{.name = "w"}});
  CHECK_THROWS_WITH(BodyWind(wind, surface, {.rotation = 2.0 * Matrix3d::Identity()}, Vector3d::Zero(), WindSampling::affine),
                    Catch::Contains("rotation"));
  CHECK_THROWS_WITH(BodyWind::within(wind, surface, {}, Vector3d::Zero(), -1.0), Catch::Contains("tolerance"));
}
