#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/mesh.hpp>
#include <numbers>
#include <random>

#include "compare/calibration/prediction.hpp"
#include "compare/calibration/residual_map.hpp"
#include "compare/calibration/symmetry.hpp"

using namespace compare;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

std::vector<Vector3d> some_directions(int count, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<Vector3d> list;
  for (int k = 0; k < count; ++k) list.push_back(Vector3d(normal(engine), normal(engine), normal(engine)).normalized());
  return list;
}

/// A box that feels something smooth beyond its law, of the same symmetry: drag and a side force that the law has not.
struct Truth {
  dragcore::Shape shape = dragcore::Box{2, 1, 0.7};
  const dragcore::Surface& surface = prepared_surface(shape, 2);
  std::vector<Matrix3d> group = symmetry_group(dragcore::triangulate(shape, 2));
  double kappa = 0.9, size = 0.15;

  PoseLoad::Channels at(const Vector3d& d) const {
    dragcore::Model model = dragcore::model_for(surface);
    model.precision = dragcore::Precision::full;
    model.pillow.factor = kappa;
    const dragcore::Wrench w =
        wrench(surface, {.wind = d, .reference_point = surface.centre}, {.density = 2.0 / surface.total_area}, model).total();
    PoseLoad::Channels load;
    load << w.force + size * Vector3d(d.x(), -d.y(), 0.5 * d.z()), w.torque / surface.radius;
    return load;
  }
  BodyLoads loads(const std::vector<Vector3d>& directions) const {
    BodyLoads body{.surface = &surface, .group = group, .reference_length = 1.0, .reynolds = 1e5};
    for (const Vector3d& d : directions) {
      PoseLoad pose{.name = std::to_string(body.poses.size()),
                    .to_wind = pose_towards(d, group).rotation(),
                    .known = {true, true, true, true, true, true}};
      const PoseLoad::Channels load = at(pose.direction());
      pose.load << pose.to_wind * load.head<3>(), pose.to_wind * load.tail<3>();
      pose.u.setConstant(0.002);
      body.poses.push_back(pose);
    }
    return body;
  }
};

}  // namespace

TEST_CASE("a field over directions has the symmetry of its body, passes through what it saw and leaves out as a fit without does",
          "[residual_map][invariance]") {
  const std::vector<Matrix3d> group = symmetry_group(dragcore::triangulate(dragcore::Box{2, 1, 1}, 1));
  for (const bool axial : {false, true}) {
    std::vector<DirectionField::Observation> seen;
    for (const Vector3d& d : some_directions(6, 3)) {
      const Vector3d stretched = Vector3d(1, 2, 2).cwiseProduct(d), value = axial ? Vector3d(d.cross(stretched)) : stretched;  // of that symmetry
      for (int axis = 0; axis < 3; ++axis)
        seen.push_back({d, Vector3d::Unit(axis), value[axis], 1e-4, static_cast<int>(seen.size() / 3)});
    }
    const DirectionField field(seen, group, axial, {0.7, 1.0});
    constexpr double rounding = 1e-6;  // u of 1e-4 beside a size of 1: digits lost as by a condition of 1e8
    for (const auto& one : seen) CHECK(std::abs(one.axis.dot(field.mean(one.direction)) - one.value) < 1e-3);
    for (const Vector3d& d : some_directions(5, 8))
      for (const Matrix3d& g : group) {
        const double sign = axial ? g.determinant() : 1.0;
        CHECK((field.mean(g * d) - sign * (g * field.mean(d))).norm() < rounding);
        CHECK(std::abs(field.spread(g * d) - field.spread(d)) < rounding);
      }
    // Where symmetry allows no lateral force there is none: in a mirror plane a polar vector stays in it, an axial one stands on it.
    const Vector3d in_plane = Vector3d(0.6, 0.0, 0.8);
    const Vector3d found = field.mean(in_plane);
    CHECK((axial ? std::hypot(found.x(), found.z()) : std::abs(found.y())) < rounding);
    const Eigen::VectorXd left = field.left_out_residuals();
    for (int pose = 0; pose < 6; ++pose) {
      std::vector<DirectionField::Observation> rest;
      for (const auto& one : seen)
        if (one.pose != pose) rest.push_back(one);
      const DirectionField without(rest, group, axial, {0.7, 1.0});
      for (std::size_t k = 0; k < seen.size(); ++k)
        if (seen[k].pose == pose)
          CHECK(std::abs(left[static_cast<Eigen::Index>(k)] - (seen[k].value - seen[k].axis.dot(without.mean(seen[k].direction)))) <
                1e-5);  // both sides have that rounding
    }
  }
}

TEST_CASE("a fit finds the pillow of a body and what it feels beyond its law, also where it has not looked", "[residual_map][analytic]") {
  const Truth truth;
  const BodyLoads body = truth.loads(next_directions({}, truth.group, 0.7, 8));
  const ResidualFit fit = fit_residual_map(body, "a test");
  REQUIRE(fit.pillow);
  CHECK(std::abs(fit.pillow->value - truth.kappa) < 0.02);  // the table's steps of 0.05, a parabola between
  REQUIRE(fit.pillow->interval);
  CHECK(fit.pillow->interval->first <= fit.pillow->value);
  CHECK(fit.pillow->interval->second >= fit.pillow->value);
  // 15 % of force beyond the law, a smooth map of eight poses and a law in between: a tenth of it.
  const PoseErrors elsewhere = pose_errors(body, truth.loads(some_directions(40, 5)).poses, fit.model);
  dragcore::Model law = fit.model;
  law.correction.reset();
  const PoseErrors without = pose_errors(body, truth.loads(some_directions(40, 5)).poses, law);
  CHECK(without.mean_force > 0.08);
  CHECK(elsewhere.mean_force < 0.25 * without.mean_force);
  CHECK(fit.map().seen.mean_force < 0.02);
  REQUIRE(fit.map().unseen);
  CHECK(fit.map().unseen->mean_force < 0.5 * fit.errors[1].seen.mean_force);
  CHECK(fit.model.correction->body == truth.surface.shape_moments);
  // And without anything beyond the law none is made.
  Truth lawful;
  lawful.size = 0.0;
  const ResidualFit nothing = fit_residual_map(lawful.loads(next_directions({}, truth.group, 0.7, 8)), "a test");
  CHECK(nothing.map().unseen->mean_force < 1e-3);
}

TEST_CASE("drag alone is enough for a map of drag; two poses are not; a table of poses that are one by symmetry leaves them out together",
          "[residual_map][limit]") {
  const Truth truth;
  BodyLoads body = truth.loads(next_directions({}, truth.group, 0.7, 6));
  for (PoseLoad& pose : body.poses) pose.known[3] = pose.known[4] = pose.known[5] = false;
  CHECK_FALSE(fit_residual_map(body, "a test").pillow);
  body.poses.resize(2);
  CHECK_THROWS_WITH(fit_residual_map(body, "a test"), Catch::Contains("2 poses") && Catch::Contains("at least 3"));
  // Four directions and their mirror images: as unsure as four.
  std::vector<Vector3d> four = some_directions(4, 2), eight = four;
  for (const Vector3d& d : four) eight.push_back(Vector3d(d.x(), -d.y(), d.z()));
  const PoseErrors once = *fit_residual_map(truth.loads(four), "a test").map().unseen,
                   twice = *fit_residual_map(truth.loads(eight), "a test").map().unseen;
  CHECK(twice.mean_force > 0.7 * once.mean_force);
}

TEST_CASE("a pose has the wind along any direction of the body, edges where incidence is 90 degrees among them",
          "[residual_map][analytic]") {
  const std::vector<Matrix3d> cube = symmetry_group(dragcore::triangulate(dragcore::Box{1, 1, 1}, 1));
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vector3d direction = Vector3d(x, y, z).normalized();
        for (const auto& group : {cube, std::vector<Matrix3d>{Matrix3d::Identity()}}) {
          const Matrix3d rotation = pose_towards(direction, group).rotation();
          CHECK((rotation.row(0).transpose() - direction).norm() < 0.002);  // tenths of a degree
        }
      }
}

TEST_CASE("poses planned for a body of many mirror planes are all different", "[residual_map][limit]") {
  const std::vector<Matrix3d> group = symmetry_group(dragcore::triangulate(dragcore::Cone{}, 8));
  const std::vector<Vector3d> list = next_directions({}, group, 0.7, 12);
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (const Matrix3d& g : group) CHECK((list[i] - g * list[j]).norm() > 0.03);  // 2 degrees: twelve are many for half a circle
}

TEST_CASE("planned poses are spread over all directions modulo symmetry, on mirror planes where near, and go on from those known",
          "[residual_map][analytic]") {
  const Truth truth;
  const std::vector<Vector3d> first = next_directions({}, truth.group, 0.7, 6), all = next_directions(first, truth.group, 0.7, 4);
  std::vector<Vector3d> list = first;
  list.insert(list.end(), all.begin(), all.end());
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j)
      for (const Matrix3d& g : truth.group) CHECK((list[i] - g * list[j]).norm() > 0.15);  // 9 degrees
    for (const Vector3d& normal : mirror_normals(truth.group)) {
      const double off = std::abs(list[i].dot(normal));
      CHECK((off < 1e-9 || off > std::sin(7.0 * std::numbers::pi / 180.0)));  // put on one plane, another may come nearer by a little
    }
    // A pose says the same in tenths of a degree.
    const Matrix3d rotation = pose_towards(list[i], truth.group).rotation();
    CHECK((rotation.row(0).transpose() - list[i]).norm() < 0.003);
    CHECK((rotation.row(0).transpose() - pose_towards(list[i], {Matrix3d::Identity()}).rotation().row(0).transpose()).norm() < 0.005);
    CHECK((rotation * rotation.transpose() - Matrix3d::Identity()).norm() < 1e-12);
  }
}
