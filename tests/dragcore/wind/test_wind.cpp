#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/turbulence.hpp>
#include <dragcore/wind.hpp>
#include <limits>
#include <numbers>
#include <random>

using namespace dragcore;
using Catch::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3i;
using std::numbers::pi;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

std::shared_ptr<const GridField> grid_field(Grid grid) { return std::make_shared<const GridField>(std::move(grid)); }

Grid random_grid(const Vector3i& points, Outside outside = Outside::zero, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-5.0, 5.0);
  Grid grid{.points = points,
            .lower = {-1.0, 0.5, 2.0},
            .upper = {2.0, 1.5, 7.0},
            .values = Eigen::Matrix3Xd(3, points.prod()),
            .outside = outside};
  for (double& value : grid.values.reshaped()) value = uniform(random);
  return grid;
}

/// A field at the grid's points: `f` is reproduced exactly by trilinear interpolation when it is trilinear itself.
template <class Function>
Grid filled(Grid grid, const Function& f) {
  const Vector3d step = (grid.upper - grid.lower).array() / (grid.points.array() - 1).max(1).cast<double>();
  grid.values.resize(3, grid.points.prod());
  Eigen::Index column = 0;
  for (int k = 0; k < grid.points[2]; ++k)
    for (int j = 0; j < grid.points[1]; ++j)
      for (int i = 0; i < grid.points[0]; ++i)
        grid.values.col(column++) = f(Vector3d(grid.lower.array() + step.array() * Eigen::Array3d(i, j, k)));
  return grid;
}

Vector3d trilinear(const Vector3d& p) {
  return {1.0 + p[0] - 2.0 * p[1] + 0.5 * p[2] * p[0], 3.0 * p[1] * p[2] - p[0] * p[1] * p[2], 0.3 * p[0] * p[1] + p[2]};
}

std::vector<Vector3d> points_in(const Eigen::AlignedBox3d& box, int count, unsigned seed = 7) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i)
    points.push_back(box.min().array() + box.sizes().array() * Eigen::Array3d(uniform(random), uniform(random), uniform(random)));
  return points;
}

/// Largest difference between a gradient and central differences: the step makes error h^2 f'''/6 and rounding 1e-16/h about equal.
double gradient_error(const Wind& wind, const Vector3d& point, double h) {
  const Matrix3d gradient = wind.sample(point).gradient;
  Matrix3d difference;
  for (int a = 0; a < 3; ++a)
    difference.col(a) = (wind.velocity(point + h * Vector3d::Unit(a)) - wind.velocity(point - h * Vector3d::Unit(a))) / (2.0 * h);
  return (gradient - difference).norm();
}

Placement tilted(const Vector3d& scale = Vector3d::Ones()) {
  return {.position = {3.0, -2.0, 1.0},
          .rotation = Eigen::AngleAxisd(0.9, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix(),
          .scale = scale};
}

}  // namespace

TEST_CASE("interpolation returns the values at grid points and a trilinear field everywhere", "[dragcore][wind][errata][analytic]") {
  const Grid grid = random_grid({4, 3, 5});
  const GridField field(grid);
  const Vector3d step = (grid.upper - grid.lower).array() / Eigen::Array3d(3, 2, 4);
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 4; ++i) {
        // Including the far ends, where the note's cell index is the last one (erratum E26). The points' own positions carry rounding: 5
        // m/s over 1/3 m times 1e-15.
        Vector3d p = grid.lower.array() + step.array() * Eigen::Array3d(i, j, k);
        if (i == 3) p[0] = grid.upper[0];
        if (j == 2) p[1] = grid.upper[1];
        if (k == 4) p[2] = grid.upper[2];
        CHECK((field.velocity(p) - grid.values.col((k * 3 + j) * 4 + i)).norm() < 1e-13);
      }
  CHECK(field.velocity(grid.upper) == grid.values.col(59));
  CHECK(field.velocity(grid.lower) == grid.values.col(0));

  const GridField smooth(filled(random_grid({4, 3, 5}), trilinear));
  for (const Vector3d& p : points_in({grid.lower, grid.upper}, 200)) {
    CHECK((smooth.velocity(p) - trilinear(p)).norm() < 1e-13);
    Matrix3d gradient;
    gradient << 1.0 + 0.5 * p[2], -2.0, 0.5 * p[0],                        //
        -p[1] * p[2], 3.0 * p[2] - p[0] * p[2], 3.0 * p[1] - p[0] * p[1],  //
        0.3 * p[1], 0.3 * p[0], 1.0;
    CHECK((smooth.sample(p).gradient - gradient).norm() < 1e-12);
    CHECK(smooth.sample(p).velocity == smooth.velocity(p));
  }
}

TEST_CASE("interpolation is continuous across cells and never leaves the range of its corners", "[dragcore][wind][limit]") {
  const Grid grid = random_grid({4, 3, 5});
  const GridField field(grid);
  const Vector3d largest = grid.values.rowwise().maxCoeff(), smallest = grid.values.rowwise().minCoeff();
  for (const Vector3d& p : points_in({grid.lower, grid.upper}, 300)) {
    const Vector3d v = field.velocity(p);
    CHECK((v.array() <= largest.array() + 1e-14).all());
    CHECK((v.array() >= smallest.array() - 1e-14).all());
    // On a plane of grid points and one ulp to either side: no jump. Slope at most 10 m/s per 0.5 m.
    const double plane = 0.0;  // second plane of x: -1, 0, 1, 2
    const Vector3d on(plane, p[1], p[2]), before(std::nextafter(plane, -1.0), p[1], p[2]), behind(std::nextafter(plane, 1.0), p[1], p[2]);
    CHECK((field.velocity(on) - field.velocity(before)).norm() < 1e-13);
    CHECK((field.velocity(on) - field.velocity(behind)).norm() < 1e-13);
    // Where the gradient jumps it is the one of the cell above.
    CHECK((field.sample(on).gradient - field.sample(Vector3d(1e-9, p[1], p[2])).gradient).norm() < 1e-6);
  }
}

TEST_CASE("outside a grid there is no wind, or that of the nearest point of its box", "[dragcore][wind][errata][limit]") {
  const GridField zero(random_grid({4, 3, 5})), clamped(random_grid({4, 3, 5}, Outside::clamp));
  const Vector3d lower = zero.grid().lower, upper = zero.grid().upper, middle = 0.5 * (lower + upper);
  for (int a = 0; a < 3; ++a)
    for (const bool above : {false, true}) {
      Vector3d on = middle;
      on[a] = above ? upper[a] : lower[a];
      Vector3d beside = on, far = on;
      beside[a] = std::nextafter(on[a], above ? infinity : -infinity);
      far[a] += above ? 1e9 : -1e9;
      // The surface belongs to the box; one ulp beyond does not.
      CHECK(zero.velocity(on) == clamped.velocity(on));
      CHECK(zero.velocity(on).norm() > 0.0);
      for (const Vector3d& p : {beside, far}) {
        CHECK(zero.sample(p).velocity == Vector3d::Zero());
        CHECK(zero.sample(p).gradient == Matrix3d::Zero());
        CHECK(clamped.velocity(p) == clamped.velocity(on));
        CHECK(clamped.sample(p).gradient.col(a) == Vector3d::Zero());
        CHECK(clamped.sample(p).gradient.norm() > 0.0);  // along the face it still changes
      }
    }
  CHECK(clamped.velocity(Vector3d::Constant(-1e300)) == clamped.velocity(lower));
}

TEST_CASE("a grid of one point, one cell or one layer works", "[dragcore][wind][hard]") {
  const Vector3d value(1.0, 2.0, 3.0);
  const GridField point(filled(random_grid({1, 1, 1}), [&](const Vector3d&) { return value; }));
  for (const Vector3d& p : {point.grid().lower, point.grid().upper, Vector3d(0.3, 0.7, 3.0)}) {
    CHECK(point.velocity(p) == value);
    CHECK(point.sample(p).gradient == Matrix3d::Zero());
  }
  CHECK(point.velocity(Vector3d(0.3, 0.7, 7.1)) == Vector3d::Zero());
  const GridField cell(filled(random_grid({2, 2, 2}), trilinear));
  CHECK((cell.velocity(Vector3d(0.3, 0.7, 3.0)) - trilinear(Vector3d(0.3, 0.7, 3.0))).norm() < 1e-13);
  const GridField layer(filled(random_grid({3, 1, 3}), [](const Vector3d& p) { return Vector3d(p[0], 0.0, p[2]); }));
  CHECK((layer.velocity(Vector3d(0.3, 1.2, 3.3)) - Vector3d(0.3, 0.0, 3.3)).norm() < 1e-14);
  CHECK(layer.sample(Vector3d(0.3, 1.2, 3.3)).gradient.col(1) == Vector3d::Zero());
}

TEST_CASE("a grid that cannot be sampled is refused, and the message says why", "[dragcore][wind][hard]") {
  const auto refused = [](const auto& change, const std::string& what) {
    Grid grid = random_grid({4, 3, 5});
    change(grid);
    CHECK_THROWS_WITH(GridField(grid), Contains(what));
  };
  refused([](Grid& g) { g.points[1] = 0; }, "at least 1");
  refused([](Grid& g) { g.points[1] = -3; }, "at least 1");
  refused([](Grid& g) { g.points = {2'000'000'000, 2'000'000'000, 2'000'000'000}; }, "number of values = 60");
  refused([](Grid& g) { g.values.setZero(3, 59); }, "number of values = 59, but the product of the points per axis is 60");
  refused([](Grid& g) { g.values(2, 17) = not_a_number; }, "value 17");
  refused([](Grid& g) { g.values(0, 0) = infinity; }, "value 0");
  refused([](Grid& g) { g.lower[0] = not_a_number; }, "lower");
  refused([](Grid& g) { g.upper = g.lower; }, "upper - lower");
  refused([](Grid& g) { g.upper[2] = g.lower[2] - 1.0; }, "greater than 0 m");
  refused([](Grid& g) { g.lower[0] = 0.0, g.upper[0] = 5e-324; }, "too small");
}

TEST_CASE("vortex and jet have the published profiles and the gradients of their velocities", "[dragcore][wind][analytic]") {
  const double circulation = 12.0, core = 0.8;
  const Wind vortex({{.field = VortexField{circulation, core}}});
  for (const double r : {0.01, 0.5, 0.8968, 3.0, 100.0}) {
    const Vector3d v = vortex.velocity(Vector3d(0.0, r, 5.0));
    CHECK_THAT(v[0], WithinRel(-circulation / (2 * pi * r) * -std::expm1(-r * r / (core * core)), 1e-13));
    CHECK(v.tail<2>().norm() < 1e-15);
  }
  // The swirl is largest at 1.1209 core radii.
  const double top = vortex.velocity(Vector3d(1.12091 * core, 0, 0))[1];
  CHECK(top > vortex.velocity(Vector3d(1.11 * core, 0, 0))[1]);
  CHECK(top > vortex.velocity(Vector3d(1.13 * core, 0, 0))[1]);
  // On the axis: solid rotation at Gamma / (2 pi a^2).
  CHECK(vortex.velocity(Vector3d::Zero()) == Vector3d::Zero());
  CHECK_THAT(vortex.sample(Vector3d::Zero()).gradient(1, 0), WithinRel(circulation / (2 * pi * core * core), 1e-14));

  const double speed = 20.0, diameter = 0.5, b0 = diameter / std::sqrt(2.0);
  const Wind jet({{.field = JetField{speed, diameter}}});
  for (const double x : {0.0, 1.0, 30.0}) {
    // Momentum flux of the profile, pi b^2 u^2 / 2, against that of the nozzle: exact by construction of the half-width.
    double flux = 0.0;
    const double b = b0 + 0.107 * x;
    for (int i = 0; i < 4000; ++i) {
      const double r = (i + 0.5) * 6.0 * b / 4000;
      flux += std::pow(jet.velocity(Vector3d(x, r, 0.0))[0], 2) * 2 * pi * r * 6.0 * b / 4000;
    }
    CHECK_THAT(flux, WithinRel(speed * speed * pi * diameter * diameter / 4, 1e-5));  // midpoint rule of 4,000 slices
    CHECK_THAT(jet.velocity(Vector3d(x, 0.0, 0.0))[0], WithinRel(speed * b0 / b, 1e-14));
  }
  CHECK(jet.velocity(Vector3d(-diameter, 0.1, 0.0)) == Vector3d::Zero());
  CHECK(jet.velocity(Vector3d(2.0, 3.0, 0.0))[1] < 0.0);  // air is drawn in from the side

  for (const Vector3d& p : points_in({Vector3d(-0.6, -1.0, -1.0), Vector3d(3.0, 1.0, 1.0)}, 300)) {
    // h = 1e-5: h^2 times third derivatives below 1e4 m^-2 s^-1, and 20 * 1e-16 / h.
    CHECK(gradient_error(vortex, p, 1e-5) < 1e-7);
    CHECK(gradient_error(jet, p, 1e-5) < 1e-6);
    CHECK_THAT(vortex.sample(p).gradient.trace(), WithinAbs(0.0, 1e-12));
    if (p[0] > 0.0) CHECK_THAT(jet.sample(p).gradient.trace(), WithinAbs(0.0, 1e-12));
  }
}

TEST_CASE("gradients are right for placed, stretched, mirrored and faded sources of every kind", "[dragcore][wind][analytic]") {
  const Grid grid = filled(random_grid({4, 3, 5}, Outside::clamp), trilinear);
  const std::vector<Field> fields{UniformField{{1.0, -2.0, 3.0}}, VortexField{5.0, 0.7}, JetField{6.0, 0.8}, grid_field(grid),
                                  std::make_shared<const Turbulence>(Dryden{.length = Vector3d::Constant(15.0), .waves = 30})};
  for (const Field& field : fields)
    for (const Vector3d& scale : {Vector3d(1.0, 1.0, 1.0), Vector3d(2.0, 0.5, -1.5)})
      for (const double fade : {infinity, 4.0}) {
        const Wind wind({{.field = field, .placement = tilted(scale), .intensity = -1.3, .fade_radius = fade}}, 2.5);
        for (const Vector3d& local : points_in({Vector3d(0.1, 0.6, 2.1), Vector3d(0.9, 0.9, 3.2)}, 10)) {  // inside one cell of the grid
          const Vector3d p = tilted().position + tilted().rotation * (scale.array() * local.array()).matrix();
          INFO("field " << field.index() << ", fade radius " << fade);
          CHECK(gradient_error(wind, p, 1e-5) < 1e-6);
        }
      }
}

TEST_CASE("moving, turning and mirroring a source moves, turns and mirrors its wind", "[dragcore][wind][invariance]") {
  const auto grid = grid_field(random_grid({4, 3, 5}));
  const Wind at_home({{.field = grid}});
  for (const Vector3d& scale : {Vector3d(1, 1, 1), Vector3d(1, -1, 1), Vector3d(-1, -1, -1)}) {
    const Wind moved({{.field = grid, .placement = tilted(scale)}});
    const Matrix3d motion = tilted().rotation * scale.asDiagonal();  // orthogonal: carries positions and velocities alike
    for (const Vector3d& p : points_in({grid->grid().lower, grid->grid().upper}, 50)) {
      const WindSample here = at_home.sample(p), there = moved.sample(tilted().position + motion * p);
      CHECK((there.velocity - motion * here.velocity).norm() < 1e-13);
      CHECK((there.gradient - motion * here.gradient * motion.transpose()).norm() < 1e-12);
    }
  }
  // The mirror image of a vortex turns the other way; stretching changes where the wind blows, not how fast.
  const Vector3d p(0.4, 0.3, 0.0);
  CHECK(Wind({{.field = VortexField{3.0, 1.0}, .placement = {.scale = {1, -1, 1}}}}).velocity(p) ==
        Wind({{.field = VortexField{-3.0, 1.0}}}).velocity(p));
  CHECK(Wind({{.field = UniformField{{1, 2, 3}}, .placement = {.scale = {7, 0.1, 2}}}}).velocity(p) == Vector3d(1, 2, 3));
  CHECK(Wind({{.field = VortexField{3.0, 1.0}, .placement = {.scale = {2, 2, 2}}}}).velocity(2.0 * p) ==
        Wind({{.field = VortexField{3.0, 1.0}}}).velocity(p));
}

TEST_CASE("overlapping sources add up, in a batch to the same bits as one by one, whatever is culled", "[dragcore][wind][invariance]") {
  std::vector<WindSource> sources;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-8.0, 8.0);
  for (unsigned i = 0; i < 60; ++i)
    sources.push_back({.field = grid_field(random_grid({2, 3, 4}, Outside::zero, i)),
                       .placement = {.position = {uniform(random), uniform(random), uniform(random)},
                                     .rotation = Eigen::AngleAxisd(uniform(random), Vector3d(1, 2, 3).normalized()).toRotationMatrix(),
                                     .scale = {2.0, -3.0, 1.0}}});
  sources.push_back({.field = VortexField{4.0, 1.0}, .fade_radius = 6.0});
  sources.push_back({.field = UniformField{{0.5, 0.0, 0.0}}});
  const Wind wind(sources);
  const std::vector<Vector3d> points = points_in({Vector3d::Constant(-3.0), Vector3d::Constant(3.0)}, 400);
  Eigen::Matrix3Xd columns(3, 400);
  for (Eigen::Index i = 0; i < 400; ++i) columns.col(i) = points[static_cast<std::size_t>(i)];
  const Eigen::Matrix3Xd batch = wind.velocities(columns);
  const std::vector<WindSample> samples = wind.samples(columns);
  int overlapping = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    CHECK(batch.col(static_cast<Eigen::Index>(i)) == wind.velocity(points[i]));
    CHECK(samples[i].velocity == wind.velocity(points[i]));
    CHECK(samples[i].gradient == wind.sample(points[i]).gradient);
    // Against each source alone, added up: other order of the same sum, so rounding only.
    Vector3d sum = Vector3d::Zero();
    int hits = 0;
    for (const WindSource& source : sources) {
      const Vector3d v = Wind({source}).velocity(points[i]);
      hits += v.norm() > 0.0;
      sum += v;
    }
    overlapping += hits > 3;
    CHECK((sum - wind.velocity(points[i])).norm() < 1e-13);
  }
  CHECK(overlapping > 20);  // the case is one of overlaps
  const std::size_t near = wind.sources_near({Vector3d::Constant(-3.0), Vector3d::Constant(3.0)}).size();
  CHECK(near < 50);  // and of culling
  CHECK(near > 3);
  CHECK(wind.velocities(Eigen::Matrix3Xd(3, 0)).cols() == 0);
  CHECK(Wind({}).sample(points[0]).velocity == Vector3d::Zero());
}

TEST_CASE("the bounding box of a source never hides a point of its field", "[dragcore][wind][hard]") {
  // Corners of turned and stretched boxes, pulled inwards by 1e-12 of their size: always inside.
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    const Grid grid = filled(random_grid({2, 2, 2}), [](const Vector3d&) { return Vector3d(1, 0, 0); });
    const Placement placement{
        .position = 100.0 * Vector3d(normal(random), normal(random), normal(random)),
        .rotation = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized().toRotationMatrix(),
        .scale = Vector3d(normal(random), normal(random), normal(random)) + Vector3d::Constant(1e-3)};
    const Wind wind({{.field = grid_field(grid), .placement = placement}});
    const Vector3d middle = 0.5 * (grid.lower + grid.upper), half = 0.5 * (1.0 - 1e-10) * (grid.upper - grid.lower);
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3d local = middle.array() + half.array() * Eigen::Array3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      const Vector3d p = placement.position + placement.rotation * (placement.scale.array() * local.array()).matrix();
      CHECK_THAT(wind.velocity(p).norm(), WithinAbs(1.0, 1e-13));
    }
  }
}

TEST_CASE("a faded source has no edge", "[dragcore][wind][limit]") {
  const Wind wind({{.field = UniformField{{2.0, 0.0, 0.0}}, .fade_radius = 5.0}});
  CHECK(wind.velocity(Vector3d::Zero()) == Vector3d(2.0, 0.0, 0.0));
  CHECK_THAT(wind.velocity(Vector3d(3.0, 0.0, 0.0))[0], WithinRel(2.0 * 0.64 * 0.64, 1e-15));
  for (const double r : {5.0, std::nextafter(5.0, 6.0), 1e9}) {
    CHECK(wind.sample(Vector3d(0.0, r, 0.0)).velocity == Vector3d::Zero());
    CHECK(wind.sample(Vector3d(0.0, r, 0.0)).gradient == Matrix3d::Zero());
  }
  // Towards the edge value and slope go to zero.
  CHECK(wind.sample(Vector3d(0.0, 5.0 - 1e-6, 0.0)).velocity.norm() < 1e-12);
  CHECK(wind.sample(Vector3d(0.0, 5.0 - 1e-6, 0.0)).gradient.norm() < 1e-6);
}

TEST_CASE("the stated bounds hold for every point of the ball, and are not idle", "[dragcore][wind][limit]") {
  const std::vector<std::pair<std::string, Field>> fields{{"uniform", UniformField{{1.0, -2.0, 3.0}}},
                                                          {"vortex", VortexField{5.0, 0.7}},
                                                          {"jet", JetField{6.0, 0.8}},
                                                          {"clamped grid", grid_field(random_grid({4, 3, 5}, Outside::clamp))},
                                                          {"grid, zero outside", grid_field(random_grid({4, 3, 5}))}};
  std::mt19937 random(13);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  for (const auto& [name, field] : fields)
    for (const Vector3d& scale : {Vector3d(1.0, 1.0, 1.0), Vector3d(2.0, 0.5, -1.5)})
      for (const double fade : {infinity, 5.0})
        for (const double radius : {0.01, 0.2, 1.5}) {
          const Wind wind({{.field = field, .placement = tilted(scale), .intensity = 1.7, .fade_radius = fade}});
          double tightest = 0.0;
          for (int place = 0; place < 40; ++place) {
            // About the cores of vortex and jet, and in and around the grids' box.
            const bool grid = name.find("grid") != std::string::npos;
            const Vector3d spread = grid ? Vector3d(4.0, 1.6, 6.0) : Vector3d(4.0, 3.0, 3.0),
                           middle = grid ? Vector3d(0.5, 1.0, 4.5) : Vector3d(1.0, 0.0, 0.0);
            const Vector3d local =
                middle.array() + spread.array() * (Eigen::Array3d(uniform(random), uniform(random), uniform(random)) - 0.5);
            const Vector3d centre = tilted().position + tilted().rotation * (scale.array() * local.array()).matrix();
            const double triangle = 0.3 * radius;
            const WindVariation stated = wind.variation(centre, radius, triangle);
            const WindSample at_centre = wind.sample(centre);
            double constant = 0.0, affine = 0.0, per_triangle = 0.0;
            for (int i = 0; i < 60; ++i) {
              const Vector3d direction = Vector3d(normal(random), normal(random), normal(random)).normalized();
              const Vector3d d = radius * std::sqrt(uniform(random)) * direction;
              const Vector3d v = wind.velocity(centre + d),
                             aside = triangle * Vector3d(normal(random), normal(random), normal(random)).normalized();
              constant = std::max(constant, (v - at_centre.velocity).norm());
              affine = std::max(affine, (v - at_centre.velocity - at_centre.gradient * d).norm());
              if ((d + aside).norm() <= radius) per_triangle = std::max(per_triangle, (wind.velocity(centre + d + aside) - v).norm());
            }
            INFO(name << ", scale " << scale.transpose() << ", fade " << fade << ", radius " << radius << ", local " << local.transpose());
            // 1e-12: rounding of velocities of some 10 m/s.
            CHECK(constant <= stated.constant + 1e-12);
            CHECK(affine <= stated.affine + 1e-12);
            CHECK(per_triangle <= stated.per_triangle + 1e-12);
            if (stated.constant > 0.0) tightest = std::max(tightest, constant / stated.constant);
          }
          // Not idle: at the best place at least a twentieth of the bound is reached; stretching (the longest axis counts) and fading (its
          // steepest slope counts) loosen it.
          if (name != "uniform" && std::isinf(fade)) {
            INFO(name << ", scale " << scale.transpose() << ", radius " << radius);
            CHECK(tightest > 0.05);
          }
        }
}

TEST_CASE("a body far smaller than the field needs one sample, a larger one the gradient, the largest every triangle",
          "[dragcore][wind][limit]") {
  const Wind wind({{.field = VortexField{.circulation = 20.0, .core_radius = 2.0}}});
  const Vector3d centre(2.0, 0.0, 0.0);
  const auto choice = [&](double radius) { return choose_sampling(wind.variation(centre, radius, 0.01 * radius), 0.05); };
  CHECK(choice(0.01) == WindSampling::constant);
  CHECK(choice(0.15) == WindSampling::affine);
  CHECK(choice(3.0) == WindSampling::per_triangle);
  // Constant falls with the radius, affine with its square.
  const WindVariation small = wind.variation(centre, 1e-3), smaller = wind.variation(centre, 5e-4);
  CHECK_THAT(small.constant / smaller.constant, WithinRel(2.0, 1e-2));
  CHECK_THAT(small.affine / smaller.affine, WithinRel(4.0, 1e-2));
  CHECK(Wind({{.field = UniformField{{9.0, 0.0, 0.0}}}}).variation(centre, 1e6).constant == 0.0);
  CHECK(Wind({}).variation(centre, 1.0).constant == 0.0);
  // A grid that is zero outside has an edge that no triangle size can resolve: its jump is stated.
  const auto cell = grid_field(filled(random_grid({2, 2, 2}), [](const Vector3d&) { return Vector3d(3, 0, 0); }));
  const Wind edge({{.field = cell}});
  CHECK_THAT(edge.variation(Vector3d(2.0, 1.0, 4.0), 0.1, 1e-9).per_triangle, WithinAbs(3.0, 1e-12));
  CHECK(edge.variation(Vector3d(0.5, 1.0, 4.0), 0.1).constant < 1e-12);
  // Clamped, it stops changing at its edge: there even a linear field is not affine. Along x from the upper face it falls short by the
  // slope times the way.
  const auto ramp =
      grid_field(filled(random_grid({4, 3, 5}, Outside::clamp), [](const Vector3d& p) { return Vector3d(2.0 * p[0], 0, 0); }));
  CHECK(Wind({{.field = ramp}}).variation(Vector3d(0.5, 1.0, 4.5), 0.3).affine < 1e-12);
  CHECK(Wind({{.field = ramp}}).variation(Vector3d(2.0, 1.0, 4.5), 0.3).affine >= 2.0 * 0.3 * (1 - 1e-12));
  CHECK_THROWS_WITH(wind.variation(centre, -1.0), Contains("radius"));
  CHECK_THROWS_WITH(wind.variation(Vector3d(not_a_number, 0, 0), 1.0), Contains("centre"));
}

TEST_CASE("a point that is not a number gives a wind that is not a number, never a plausible one", "[dragcore][wind][hard]") {
  const Wind wind({{.field = grid_field(random_grid({4, 3, 5}))}, {.field = VortexField{1.0, 1.0}, .fade_radius = 3.0}});
  const Vector3d nowhere(not_a_number, 1.0, 3.0);
  CHECK(wind.velocity(nowhere).hasNaN());
  Eigen::Matrix3Xd points(3, 2);
  points << nowhere, Vector3d(0.0, 1.0, 3.0);
  CHECK(wind.velocities(points).col(0).hasNaN());
  CHECK(wind.velocities(points).col(1) == wind.velocity(points.col(1)));
}

TEST_CASE("fields of a micrometre and of a million metres, near and far, are sampled alike", "[dragcore][wind][hard]") {
  const auto grid = grid_field(filled(random_grid({4, 3, 5}), trilinear));
  const Vector3d local(0.31, 0.77, 4.1);
  for (const double size : {1e-6, 1e-3, 1.0, 1e6, 1e100})
    for (const double distance : {0.0, 1e4 * size, 1e9 * size}) {
      const Vector3d position = Vector3d::Constant(distance), p = position + size * local;
      const WindSample sample = Wind({{.field = grid, .placement = {.position = position, .scale = Vector3d::Constant(size)}}}).sample(p);
      // The point itself is rounded to 1e-16 of its distance; the field changes by about 20 m/s per metre of its own.
      const double rounding = 20.0 * (2e-15 + 1e-15 * distance / size);
      CHECK((sample.velocity - trilinear(local)).norm() < rounding);
      CHECK((sample.gradient * size - grid->sample(local).gradient).norm() < 1e-12 + 10.0 * rounding);
    }
  // Denormal points and core radii far below and above the distance.
  for (const double r : {0.0, 5e-324, 1e-160, 1e-12, 1e12, 1e150})
    for (const double core : {1e-6, 1.0, 1e6}) {
      const WindSample sample = Wind({{.field = VortexField{1.0, core}}}).sample(Vector3d(r, 0.0, 0.0));
      CHECK(sample.velocity.allFinite());
      CHECK(sample.gradient.allFinite());
      CHECK(sample.velocity.norm() <= 0.6382 / (2 * pi * core) * (1 + 1e-12));  // the largest swirl there is
    }
}

TEST_CASE("a source that cannot be placed is refused by name, and the message says why", "[dragcore][wind][hard]") {
  const auto refused = [](WindSource source, const std::string& what) {
    source.name = "courtyard";
    CHECK_THROWS_WITH(Wind({source}), Contains("'courtyard'") && Contains(what));
  };
  refused({.placement = {.position = {not_a_number, 0, 0}}}, "position");
  refused({.placement = {.scale = {1.0, 0.0, 1.0}}}, "scale = (1 0 1), but it must be finite and not 0");
  refused({.placement = {.scale = {1.0, 5e-324, 1.0}}}, "scale");
  refused({.placement = {.scale = {1.0, infinity, 1.0}}}, "scale");
  refused({.placement = {.rotation = Matrix3d::Zero()}}, "rotation");
  refused({.placement = {.rotation = Vector3d(1, -1, 1).asDiagonal()}}, "mirrors into the scale");
  refused({.intensity = not_a_number}, "intensity");
  refused({.fade_radius = 0.0}, "fade_radius");
  refused({.fade_radius = not_a_number}, "fade_radius");
  refused({.field = UniformField{{0, infinity, 0}}}, "velocity");
  refused({.field = VortexField{1.0, 0.0}}, "core_radius");
  refused({.field = VortexField{not_a_number, 1.0}}, "circulation");
  refused({.field = JetField{1.0, -1.0}}, "diameter");
  refused({.field = JetField{not_a_number, 1.0}}, "exit_speed");
  refused({.field = std::shared_ptr<const GridField>()}, "field");
  CHECK_THROWS_WITH(Wind({}, not_a_number), Contains("time"));
}
