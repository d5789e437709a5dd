#include <catch2/catch.hpp>

#include "compare/calibration/prediction.hpp"
#include "tests/compare/sample_records.hpp"

namespace {

double drag(const sample::CaseRecord& record, const dragcore::Model& model = {}, int divisions = 0) {
  const auto wrench = compare::predict(record, model, divisions).total();
  return *compare::coefficients(record, wrench.force, wrench.torque)[compare::Channel::drag];
}

}  // namespace

TEST_CASE("predictions of the note's law have their exact drag coefficients", "[compare][analytic]") {
  // Flat sides: rounding only.
  CHECK(drag(sample::record("box", dragcore::Box{}, {})) == Approx(1.0).epsilon(1e-12));
  CHECK(drag(sample::record("box", dragcore::Box{}, {.yaw = 45 * sample::deg})) ==
        Approx(std::sqrt(2.0) * (1.0 - std::sqrt(2.0) / 4.0)).epsilon(1e-12));
  CHECK(drag(sample::record("sheet", dragcore::Plate{.chord = 1.0, .span = 1.0, .thickness = 0.0}, {.incidence = 90 * sample::deg})) ==
        Approx(1.0).epsilon(1e-12));
}

TEST_CASE("default divisions keep the error of round bodies below 0.3 percent", "[compare][convergence]") {
  const auto sphere = sample::record("sphere", dragcore::Sphere{}, {});
  const double exact = 0.6;
  CHECK(std::abs(drag(sphere) - exact) < 0.003 * exact);
  const double coarse = std::abs(drag(sphere, {}, 8) - exact), fine = std::abs(drag(sphere, {}, 16) - exact);
  CHECK(std::log2(coarse / fine) == Approx(2.0).margin(0.1));  // second order: facets of a smooth surface
}

TEST_CASE("a sheet feels the air on both sides, so that turning it over mirrors the force", "[compare][invariance]") {
  const dragcore::Plate sheet{.chord = 1.0, .span = 2.0, .thickness = 0.0};
  const auto up = compare::predict(sample::record("sheet", sheet, {.incidence = 0.5}), {}).total();
  const auto down = compare::predict(sample::record("sheet", sheet, {.incidence = -0.5}), {}).total();
  CHECK(up.force.z() > 0.0);  // lifted nose: pushed up
  CHECK(down.force.x() == Approx(up.force.x()).epsilon(1e-12));
  CHECK(down.force.z() == Approx(-up.force.z()).epsilon(1e-12));
}

TEST_CASE("forces follow density and the square of speed", "[compare][invariance]") {
  auto record = sample::record("cone", dragcore::Cone{}, {.incidence = 0.7});
  const auto before = compare::predict(record, {}).total();
  record.density *= 2.0;
  record.speed *= 3.0;
  const auto after = compare::predict(record, {}).total();
  CHECK((after.force - 18.0 * before.force).norm() < 1e-12 * after.force.norm());
  CHECK((after.torque - 18.0 * before.torque).norm() < 1e-12 * after.force.norm());
}

TEST_CASE("the pillow effect moves the centre of pressure of a plate towards its nose", "[compare][sign]") {
  const auto record =
      sample::record("sheet", dragcore::Plate{.chord = 1.0, .span = 1.0, .thickness = 0.0}, {.incidence = 30 * sample::deg});
  const auto wrench =
      compare::predict(record, dragcore::Model{dragcore::note_law(), {dragcore::PillowForm::tilt, 0.78}, dragcore::Quadrature::three})
          .total();
  const auto c = compare::coefficients(record, wrench.force, wrench.torque);
  CHECK(c.centre_of_pressure.value() < 0.45);
  CHECK(*c[compare::Channel::pitch] > 0.0);  // nose up
}
