// Wind by the kernels against the same wind in double precision, on every instruction set that this machine has; in a library without
// kernels, that single precision is double.

#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/body_wind.hpp>
#include <dragcore/turbulence.hpp>
#include <limits>

#include "tests/dragcore/kernels/targets.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

int whole_number(zoo::Random& random, int low, int high) { return static_cast<int>(std::floor(random.uniform(low, high + 1.0 - 1e-9))); }

/// Sizes from one point along an axis to a dozen, values of any magnitude.
Grid random_field(zoo::Random& random) {
  Grid grid;
  for (int axis = 0; axis < 3; ++axis) {
    grid.points[axis] = whole_number(random, 1, random.uniform(0.0, 1.0) < 0.3 ? 2 : 12);
    grid.lower[axis] = random.uniform(-3.0, 0.0);
    grid.upper[axis] = grid.lower[axis] + random.uniform(0.1, 6.0);
  }
  grid.values.resize(3, grid.points.prod());
  const double speed = std::exp(random.uniform(-20.0, 20.0));
  for (double& value : grid.values.reshaped()) value = speed * random.uniform(-1.0, 1.0);
  if (random.uniform(0.0, 1.0) < 0.5) grid.outside = Outside::clamp;
  return grid;
}

struct Scene {
  std::vector<WindSource> sources;
  Matrix3Xd points;
  double scale = 0.0;  ///< sum of the largest values of the grids [m/s]
  double slope = 0.0;  ///< the same over the smallest size of a cell, and over the radius of a fading field [1/s]

  Wind wind() const { return Wind(sources, 1.5); }
};

/// Grids moved, turned, stretched, mirrored and faded, alone or among other sources, about a place anywhere in the world; points inside,
/// outside, and, where a grid is not turned, exactly on its faces, edges and corners.
Scene random_scene(zoo::Random& random) {
  Scene scene;
  const Vector3d place = random.vector(random.uniform(0.0, 1.0) < 0.3 ? 1e6 : 5.0);
  std::vector<Vector3d> points;
  for (int i = 0, count = whole_number(random, 1, 8); i < count; ++i) {
    const Grid grid = random_field(random);
    WindSource source{.field = std::make_shared<const GridField>(grid),
                      .placement = {.position = place + random.vector(1.0)},
                      .intensity = random.uniform(-2.0, 2.0)};
    const bool turned = random.uniform(0.0, 1.0) < 0.5;
    if (turned) {
      source.placement.rotation = random.rotation();
      for (double& scale : source.placement.scale) scale = std::copysign(random.uniform(0.3, 3.0), random.uniform(-1.0, 1.0));
    }
    if (random.uniform(0.0, 1.0) < 0.4) source.fade_radius = random.uniform(0.5, 4.0);
    if (!turned)
      for (int corner = 0; corner < 27; ++corner) {
        const Eigen::Array3d share(corner % 3 / 2.0, corner / 3 % 3 / 2.0, corner / 9 / 2.0);
        points.push_back(source.placement.position + (grid.lower.array() * (1.0 - share) + grid.upper.array() * share).matrix());
      }
    const double speed = std::abs(source.intensity) * grid.values.cwiseAbs().maxCoeff();
    const Eigen::Array3d cell =
        (grid.upper - grid.lower).array() * source.placement.scale.array().abs() / grid.points.array().cast<double>();
    scene.scale += speed;
    scene.slope += speed * (1.0 / cell.minCoeff() + 4.0 / (source.fade_radius * source.placement.scale.cwiseAbs().minCoeff()));
    scene.sources.push_back(std::move(source));
  }
  if (random.uniform(0.0, 1.0) < 0.5) {
    scene.sources.push_back({.field = UniformField{random.vector(1.0)}});
    scene.sources.push_back({.field = VortexField{3.0, 0.5}, .placement = {.position = place}, .fade_radius = 2.0});
    scene.sources.push_back({.field = JetField{2.0, 0.5}, .placement = {.position = place}});
  }
  if (random.uniform(0.0, 1.0) < 0.3)
    scene.sources.push_back({.field = std::make_shared<const Turbulence>(
                                 Dryden{.length = Vector3d::Constant(20.0) + random.uniform(-1.0, 1.0) * Vector3d(0, 5, 5), .waves = 48}),
                             .placement = {.position = place, .rotation = random.rotation(), .scale = {1.0, -2.0, 1.0}},
                             .fade_radius = random.uniform(0.0, 1.0) < 0.5 ? 3.0 : infinity});
  for (int i = 0, count = whole_number(random, 1, 200); i < count; ++i) points.push_back(place + random.vector(6.0));
  scene.points.resize(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) scene.points.col(static_cast<Eigen::Index>(i)) = points[i];
  return scene;
}

}  // namespace

TEST_CASE("grids by the kernels are those in double precision, over any scene and on every target", "[wind][kernels][backend]") {
  double worst = 0.0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    INFO("seed " << seed);
    zoo::Random random(seed);
    const Scene scene = random_scene(random);
    const Wind wind = scene.wind();
    const Matrix3Xd exact = wind.velocities(scene.points);
    kernels::on_every_target([&] {
      const Matrix3Xd fast = wind.velocities(scene.points, Precision::single);
      REQUIRE(fast.allFinite());
      // Rounded to 6e-8 are values, differences and fractions, three times over; other sources are as exact as before, but summed in
      // another order.
      const double error = (fast - exact).colwise().norm().maxCoeff();
      worst = std::max(worst, error / scene.scale);
      CHECK(error <= 1e-6 * scene.scale + 1e-12);
      const std::vector<WindSample> samples = wind.samples(scene.points, Precision::single);
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const WindSample one = wind.sample(scene.points.col(static_cast<Eigen::Index>(i)));
        CHECK((samples[i].velocity - one.velocity).norm() <= 1e-6 * scene.scale + 1e-12);
        CHECK((samples[i].gradient - one.gradient).norm() <= 1e-6 * scene.slope + 1e-12);
      }
    });
  }
  CHECK((worst > 1e-9) == kernels::built);  // it is the kernels that were asked, where there are any
}

TEST_CASE("wind by the kernels has the same bits at 16 and 8 points at once, at 4 and 1, and however a batch is split",
          "[wind][kernels][backend]") {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    INFO("seed " << seed);
    zoo::Random random(seed);
    const Scene scene = random_scene(random);
    const Wind wind = scene.wind();
    const auto result = [&] { return wind.velocities(scene.points, Precision::single); };
    kernels::on_equal_targets(result, [](const Matrix3Xd& wide, const Matrix3Xd& narrow) { CHECK(wide == narrow); });
    kernels::on_equal_targets([&] { return wind.samples(scene.points, Precision::single); },
                              [](const auto& wide, const auto& narrow) {
                                for (std::size_t i = 0; i < wide.size(); ++i)
                                  CHECK((wide[i].velocity == narrow[i].velocity && wide[i].gradient == narrow[i].gradient));
                              });
    const Matrix3Xd whole = result();
    for (Eigen::Index first = 0, count = 1; first < whole.cols(); first += count, count = std::min(2 * count + 1, whole.cols() - first))
      CHECK(wind.velocities(scene.points.middleCols(first, count), Precision::single) == whole.middleCols(first, count));
  }
}

TEST_CASE("a point that is not a number or infinite gets what it gets in double precision, and so do its neighbours",
          "[wind][kernels][hard]") {
  zoo::Random random(4);
  Scene scene = random_scene(random);
  const Wind wind = scene.wind();
  const Matrix3Xd undisturbed = wind.velocities(scene.points, Precision::single);
  for (const double strange : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity, 1e300, -1e300}) {
    Matrix3Xd points = scene.points;
    points(1, 3) = strange;
    kernels::on_every_target([&] {
      const Matrix3Xd here = wind.velocities(scene.points, Precision::single), fast = wind.velocities(points, Precision::single);
      const Vector3d exact = wind.velocity(points.col(3)), found = fast.col(3);
      for (int axis = 0; axis < 3; ++axis) {
        CHECK(std::isnan(exact[axis]) == std::isnan(found[axis]));
        if (!std::isnan(exact[axis])) CHECK(std::abs(found[axis] - exact[axis]) <= 1e-6 * scene.scale);
      }
      CHECK(wind.samples(points, Precision::single)[3].gradient.hasNaN() == wind.sample(points.col(3)).gradient.hasNaN());
      CHECK(fast.leftCols(3) == here.leftCols(3));
      CHECK(fast.rightCols(fast.cols() - 4) == here.rightCols(fast.cols() - 4));
    });
  }
  CHECK(undisturbed.allFinite());
}

TEST_CASE("no points, no sources, no wind, and numbers at the ends of their range", "[wind][kernels][hard]") {
  const Matrix3Xd points = Matrix3Xd::Random(3, 40);
  CHECK(Wind({}).velocities(points, Precision::single) == Matrix3Xd::Zero(3, 40));
  for (const double speed : {0.0, 5e-324, 1e-300, 1e300}) {
    Grid grid{.points = {2, 2, 2}, .lower = -Vector3d::Ones(), .upper = Vector3d::Ones(), .values = speed * Matrix3Xd::Random(3, 8)};
    const Wind wind({{.field = std::make_shared<const GridField>(grid)}});
    CHECK(wind.velocities(Matrix3Xd(3, 0), Precision::single).cols() == 0);
    kernels::on_every_target([&] {
      const Matrix3Xd fast = wind.velocities(points, Precision::single), exact = wind.velocities(points);
      CHECK((fast - exact).cwiseAbs().maxCoeff() <= 1e-6 * speed + 1e-323);  // two steps of the smallest numbers
    });
  }
  // An intensity that takes the largest value beyond all numbers, though not the value at the point.
  Grid grid{.points = {2, 1, 1}, .values = Matrix3Xd::Zero(3, 2)};
  grid.values(0, 1) = 1e200;
  const Wind wind({{.field = std::make_shared<const GridField>(grid), .intensity = 1e200}});
  CHECK(wind.velocities(Matrix3Xd::Zero(3, 5), Precision::single) == Matrix3Xd::Zero(3, 5));
  // Columns that do not follow each other in memory.
  const Eigen::Matrix4Xd wider = Eigen::Matrix4Xd::Random(4, 40);
  const Wind mixed({{.field = std::make_shared<const GridField>(Grid{.points = {2, 2, 2}, .values = Matrix3Xd::Random(3, 8)})}});
  CHECK(mixed.velocities(wider.topRows<3>(), Precision::single) == mixed.velocities(Matrix3Xd(wider.topRows<3>()), Precision::single));
}

TEST_CASE("turbulence at many points is that point by point", "[turbulence][kernels][backend]") {
  zoo::Random random(6);
  const Matrix3Xd none(3, 0);
  for (const Vector3d& length : {Vector3d(30, 30, 30), Vector3d(400, 400, 90)})
    for (const double time : {0.0, 1e5}) {
      const Turbulence turbulence({.seed = 5, .intensity = {2.0, 1.5, 1.0}, .length = length, .mean_wind = {8.0, 3.0, 1.0}, .waves = 192});
      Matrix3Xd points(3, 61);
      for (auto point : points.colwise()) point = random.vector(1000.0);
      const auto result = [&] { return turbulence.velocities(points, time); };
      kernels::on_every_target([&] {
        const Matrix3Xd fast = result();
        for (Eigen::Index i = 0; i < points.cols(); ++i)
          // The largest wavenumber is 0.57 * 192: phases of 3e6 rad after 1e5 s at 9 m/s and 30 m, three roundings of 1e-16 each; without
          // the way 4e3 rad.
          CHECK((fast.col(i) - turbulence.velocity(points.col(i), time)).norm() <= (time == 0.0 ? 1e-12 : 1e-9));
        CHECK(turbulence.velocities(none, time).cols() == 0);
      });
      kernels::on_equal_targets(result, [](const Matrix3Xd& wide, const Matrix3Xd& narrow) { CHECK(wide == narrow); });
      CHECK(turbulence.velocities(points.middleCols(7, 5), time) == result().middleCols(7, 5));
    }
}

TEST_CASE("a body's wind by triangles is the wind at their centroids, in either precision", "[body_wind][kernels][backend]") {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    zoo::Random random(seed);
    const Scene scene = random_scene(random);
    const Wind wind = scene.wind();
    const Surface surface = zoo::surface(Ellipsoid{.semi_x = 2.0, .semi_y = 1.0, .semi_z = 0.7}, 6);
    const BodyPlacement place{scene.points.col(0), random.rotation()};
    const Vector3d reference_point = random.vector(1.0);
    kernels::on_every_target([&] {
      for (const Precision precision : {Precision::full, Precision::single}) {
        Motion motion;
        const BodyWind here(wind, surface, place, reference_point, WindSampling::per_triangle, precision);
        here.apply_to(motion);
        const double tolerance = (precision == Precision::full ? 1e-13 : 1e-6) * scene.scale + 1e-12;
        const auto at = [&](const Vector3d& r) -> Vector3d {
          return place.rotation.transpose() * wind.velocity(place.rotation * r + place.position);
        };
        CHECK((motion.wind - at(reference_point)).norm() <= tolerance);
        REQUIRE(static_cast<Eigen::Index>(motion.triangle_wind.size()) == surface.size());
        for (Eigen::Index i = 0; i < surface.size(); ++i)
          CHECK((motion.triangle_wind[static_cast<std::size_t>(i)] - at(surface.centroid.row(i).matrix().transpose())).norm() <= tolerance);
      }
    });
  }
}
