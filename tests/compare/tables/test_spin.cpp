#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "compare/reference/published.hpp"
#include "compare/store/store.hpp"
#include "compare/tables/spin_table.hpp"
#include "tests/compare/sample_records.hpp"

using Catch::Contains;
using Eigen::Vector3d;

TEST_CASE("bodies that spin and bodies at rest are told apart once, and none is lost", "[compare][spin][invariance]") {
  const auto spin = sample::spinning("cube_spin-z_re-1e2-laminar", dragcore::Box{}, {0.0, 0.0, 2.0}, -0.1, 100);
  compare::Reference all{sample::quick_tier(), {}};
  all.cases.push_back(spin);
  all.patches.resize(all.cases.size());
  const auto rest = compare::at_rest(all);
  CHECK(rest.cases.size() == 12);
  CHECK(rest.patches.size() == 12);
  for (const auto& record : rest.cases) CHECK_FALSE(record.spins());
  REQUIRE(compare::spinning(all.cases).size() == 1);
  CHECK(compare::spinning(all.cases)[0].name == spin.name);
}

TEST_CASE("the model is asked about the spin in the body's frame and without wind in still air", "[compare][spin][invariance]") {
  // A plate that spins about its span, in any pose: the torque is about the axis, and no pose changes its size.
  const auto torque = [](const dragcore::Pose& pose) {
    auto record = sample::spinning("plate", dragcore::Plate{}, pose.rotation() * Vector3d(0.0, 3.0, 0.0), -0.1, 1e5);
    record.pose = pose;
    const auto wrench = compare::predict(record, {}).total();
    CHECK(wrench.force.norm() < 1e-12 * wrench.torque.norm());  // no wind: a spin about the centroid of a symmetric body has no force
    CHECK(wrench.torque.normalized().dot(record.angular_velocity.normalized()) ==
          Approx(-1.0).epsilon(1e-8));  // the air brakes; diagonals of the triangles leave 1e-5 across the axis
    return wrench.torque.norm();
  };
  CHECK(torque({.incidence = 0.5, .yaw = 0.3, .roll = 0.2}) == Approx(torque({})).epsilon(1e-12));
}

TEST_CASE("in a wind the model is asked about both, wind and spin", "[compare][spin][limit]") {
  auto record = sample::record("cube_spin-z-1", dragcore::Box{}, {});
  const auto at_rest = compare::predict(record, {}).total();
  record.angular_velocity = {0.0, 0.0, record.speed};
  const auto spun = compare::predict(record, {}).total();
  CHECK(spun.force.x() > 0.5 * at_rest.force.x());
  CHECK(spun.torque.z() < 0.0);
}

TEST_CASE("a row of the spin table has the torque about the axis, its shares, and the error of the model", "[compare][spin][analytic]") {
  const Vector3d axis = Vector3d(1.0, 1.0, 0.0).normalized();
  auto record = sample::spinning("cube_spin-xy_re-1e2-laminar", dragcore::Box{}, 2.0 * axis, -0.1, 100);
  const double scale = compare::coefficient_scales(record)[3];
  record.load.moment_pressure += 0.05 * scale * Vector3d(1.0, -1.0, 0.0);  // across the axis: not part of it
  record.u_iteration << 0.0, 0.0, 0.0, 0.003 * scale, 0.004 * scale, 0.0;
  const auto rows = compare::spin_table({record}, [&](const sample::CaseRecord&) {
    return dragcore::Wrench{Vector3d::Zero(), -0.08 * scale * axis};
  });
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].axis == "xy");
  CHECK(rows[0].cfd.value() == Approx(-0.1).epsilon(1e-12));
  CHECK(rows[0].u == Approx(0.005 / std::sqrt(2.0)).epsilon(1e-6));  // 3-4-5 over the two components of the axis; a difference quotient
  CHECK(rows[0].pressure_share.value() == Approx(0.75).epsilon(1e-12));
  CHECK(rows[0].friction_share.value() == Approx(0.25).epsilon(1e-12));
  CHECK(rows[0].error.value() == Approx(0.02).epsilon(1e-12));
  CHECK(rows[0].relative_error.value() == Approx(0.2).epsilon(1e-12));
  CHECK(rows[0].verdict == compare::Verdict::resolved);
  CHECK_FALSE(rows[0].discretisation_assessed);
}

TEST_CASE("the spin table has all formats, and a failed case keeps its row", "[compare][spin][regression]") {
  auto failed = sample::spinning("cone_spin-x_re-1e5", dragcore::Cone{}, {1.0, 0.0, 0.0}, -0.01, 1e5);
  failed.status = case_record::Status::diverged;
  failed.reason = "torque without bound";
  const auto rows =
      compare::spin_table({sample::spinning("cube_spin-z", dragcore::Box{}, {0.0, 0.0, 2.0}, -0.1, 100), failed}, compare::predictor({}));
  REQUIRE(rows.size() == 2);
  for (const auto format : {compare::Format::table, compare::Format::markdown, compare::Format::csv, compare::Format::json}) {
    const std::string text = compare::render(rows, "note", format);
    CHECK_THAT(text, Contains("diverged") && Contains("cube_spin-z"));
  }
  CHECK(nlohmann::json::parse(compare::render(rows, "note", compare::Format::json))[0]["C_spin"].is_null());
}

TEST_CASE("a sphere in creeping flow and a free disc have their exact torques", "[compare][spin][analytic]") {
  // 8 pi mu a^3 omega with a = 1/2, omega = 2, nu = omega L^2 / Re, over q A L.
  const auto sphere = sample::spinning("sphere_spin-z_re-4-laminar", dragcore::Sphere{}, {0.0, 0.0, 2.0}, -2.0, 4);
  const double pi = std::numbers::pi, a = 0.5, omega = 2.0, nu = omega / 4.0, q_area = 0.5 * std::pow(omega * 1.0, 2) * pi / 4.0;
  const double stokes = 8.0 * pi * nu * std::pow(a, 3) * omega / q_area;
  const double re_a = omega * a * a / nu;
  CHECK(compare::published_value(sphere, "C_spin")->value ==
        Approx(-stokes * (1.0 + re_a * re_a / 1200.0)).epsilon(1e-6));  // digits of the file
  const auto disc = sample::spinning("cylinder_spin-x_re-4e4-laminar", dragcore::Cylinder{.diameter = 1.0, .length = 0.05}, {2.0, 0.0, 0.0},
                                     -0.0016, 4e4);
  const double faces = 3.87 / std::sqrt(1e4) * 0.5 * omega * omega * std::pow(a, 5) / q_area;
  CHECK(compare::published_value(disc, "C_spin")->value == Approx(-1.1 * faces).epsilon(1e-6));
  // What was published of a body at rest says nothing about one that spins, and the other way round.
  auto still = sample::record("sphere", dragcore::Sphere{}, {});
  still.reynolds = 4;
  CHECK_FALSE(compare::published_value(still, "C_spin"));
  auto fast = sphere;
  fast.reynolds = 100;
  CHECK_FALSE(compare::published_value(fast, "C_D"));
}
