#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "compare/calibration/calibration.hpp"
#include "compare/calibration/prediction.hpp"
#include "compare/reference/coefficients.hpp"

using namespace compare;
using case_record::CaseRecord;
using Catch::Matchers::WithinAbs;

namespace {

/// A reference that a drag model made: what calibration must find again.
CaseRecord made_by(const dragcore::Model& model, const dragcore::Shape& shape, double incidence_deg, double yaw_deg) {
  CaseRecord record;
  record.shape = shape;
  record.pose = {.incidence = incidence_deg * std::numbers::pi / 180, .yaw = yaw_deg * std::numbers::pi / 180};
  record.name = dragcore::kind(shape) + "_" + std::to_string(incidence_deg) + "_" + std::to_string(yaw_deg) + "_re-1e5_medium";
  record.reynolds = 1e5;
  record.flow_model = "k_omega_sst";
  record.mesh_level = "medium";
  record.status = case_record::Status::steady;
  const dragcore::Wrench wrench = predict(record, model).total();
  record.load.force_pressure = wrench.force;
  record.load.moment_pressure = wrench.torque;
  record.cells = 12000;
  return record;
}

std::vector<CaseRecord> campaign(const dragcore::Model& model) {
  std::vector<CaseRecord> records;
  for (const double incidence : {0.0, 30.0, 60.0, 90.0}) records.push_back(made_by(model, dragcore::Plate{}, incidence, 0));
  for (const double yaw : {0.0, 15.0, 30.0, 45.0}) records.push_back(made_by(model, dragcore::Box{}, 0, yaw));
  for (const double incidence : {0.0, 60.0, 120.0, 180.0}) records.push_back(made_by(model, dragcore::Cone{}, incidence, 0));
  return records;
}

}  // namespace

TEST_CASE("calibration finds the coefficients that made the references", "[compare][calibration][analytic]") {
  const dragcore::Model truth{.law = dragcore::scaled_law(0.8, 0.35), .pillow = {dragcore::PillowForm::tilt, 0.7}};
  const Calibration found = calibrate(campaign(truth));
  const Fit& drag = found.fits.front();
  CHECK_THAT(drag.estimates[0].value, WithinAbs(0.8, 1e-6));  // exact references: the tolerance of the solver, 1e-12 of the cost
  CHECK_THAT(drag.estimates[1].value, WithinAbs(0.35, 1e-6));
  CHECK(drag.errors[0].n == 12);
  CHECK(drag.errors[0].before > 0.1);
  CHECK(drag.errors[0].left_out_shape < 1e-6);
  const Fit& tilt = found.fit("pillow tilt on law scaled");
  CHECK_THAT(tilt.estimates[0].value, WithinAbs(0.7, 1e-5));  // interpolation of the arm between 13 factors
  CHECK(tilt.errors[0].in_sample < 1e-6);
  // The circular form cannot follow: it must say so.
  CHECK(found.fit("pillow patch on law scaled").errors[0].in_sample > 1e-4);
}

TEST_CASE("noise in the references shows in intervals and left-out errors", "[compare][calibration]") {
  std::vector<CaseRecord> records = campaign({.law = dragcore::scaled_law(0.8, 0.35)});
  for (std::size_t i = 0; i < records.size(); ++i) records[i].load.force_pressure.x() *= i % 2 ? 1.1 : 0.9;
  const Fit drag = calibrate(records).fits.front();
  REQUIRE(drag.estimates[0].interval);
  CHECK(drag.estimates[0].interval->first < drag.estimates[0].value);
  CHECK(drag.estimates[0].value < drag.estimates[0].interval->second);
  CHECK(drag.estimates[0].interval->second - drag.estimates[0].interval->first > 0.01);
  CHECK(drag.errors[0].left_out_pose > drag.errors[0].in_sample);
  CHECK_THAT(drag.correlation[0][1], WithinAbs(drag.correlation[1][0], 1e-12));
  CHECK(drag.condition_number > 1.0);
}

TEST_CASE("cases held out, at low Reynolds number, failed or of other shapes are not fitted", "[compare][calibration]") {
  const dragcore::Model truth{.law = dragcore::scaled_law(0.8, 0.35)};
  std::vector<CaseRecord> records = campaign(truth);
  const auto spoil = [&](auto change) {
    CaseRecord record = made_by(truth, dragcore::Plate{}, 45, 0);
    record.name += std::to_string(records.size());
    record.load.force_pressure *= 100;
    change(record);
    records.push_back(record);
  };
  spoil([](CaseRecord& r) { r.held_out = true; });
  spoil([](CaseRecord& r) { r.reynolds = 100; });
  spoil([](CaseRecord& r) { r.status = case_record::Status::diverged; });
  spoil([](CaseRecord& r) { r.shape = dragcore::Sphere{}; });
  const Fit drag = calibrate(records).fits.front();
  CHECK(drag.cases.size() == 12);
  CHECK_THAT(drag.estimates[0].value, WithinAbs(0.8, 1e-6));
  CHECK_THROWS_WITH(calibrate({}), Catch::Contains("0 usable cases") && Catch::Contains("dragval run quick"));
}

TEST_CASE("the force arm is the distance of the line of action, signed like the moment", "[compare][calibration][sign]") {
  CaseRecord record;
  record.shape = dragcore::Plate{.chord = 2.0, .span = 1.0};
  // Force 3 up at x = -0.5, a quarter of the chord ahead of the middle: nose-up moment 1.5, arm 0.5 / 2.
  const auto arm = force_arm(record, Eigen::Vector3d(0, 0, 3), Eigen::Vector3d(0, 1.5, 0));
  REQUIRE(arm);
  CHECK_THAT(*arm, WithinAbs(0.25, 1e-15));
  CHECK_FALSE(force_arm(record, Eigen::Vector3d::Zero(), Eigen::Vector3d(0, 1, 0)));
}

TEST_CASE("the laws by class are found again from references that they made", "[compare][calibration][analytic]") {
  dragcore::Law sheet = dragcore::sheet_law(), closed = dragcore::closed_law();
  sheet.windward = {0.0, 1.7, -0.5, 0.0, 0.0};
  closed.windward = {0.0, 0.0, 1.4, -0.7, 0.0};
  closed.base_suction = 0.5;
  closed.recovery_depth = 0.9;
  closed.shelter = 1.1;
  std::vector<CaseRecord> records;
  for (const double incidence : {0.0, 15.0, 30.0, 60.0, 90.0}) records.push_back(made_by({.law = sheet}, dragcore::Plate{}, incidence, 0));
  for (const double length : {0.5, 1.0, 3.0})
    for (const double yaw : {0.0, 15.0, 30.0, 60.0}) {
      records.push_back(made_by({.law = closed}, dragcore::Box{length, 1.0, 1.0}, 0, yaw));
      records.back().name = std::to_string(length) + "_" + records.back().name;  // a family of its own
    }
  for (const double incidence : {0.0, 180.0}) records.push_back(made_by({.law = closed}, dragcore::Sphere{}, incidence, 0));
  records.push_back(made_by({.law = dragcore::note_law()}, dragcore::Box{2.0, 1.0, 1.0}, 0, 20));
  records.back().held_out = true;  // would spoil the fit

  const Calibration found = calibrate_class_laws(records);
  REQUIRE(found.fits.size() == 2);
  CHECK(found.fits[0].cases.size() == 5);
  CHECK(found.fits[1].cases.size() == 14);
  CHECK(found.fits[0].model.law == sheet);  // to the three decimals that laws are kept with
  CHECK_THAT(found.fits[1].model.law.base_suction, WithinAbs(0.5, 2e-3));
  CHECK_THAT(found.fits[1].model.law.windward[2], WithinAbs(1.4, 4e-3));
  CHECK_THAT(found.fits[1].model.law.recovery_depth,
             WithinAbs(0.9, 5e-3));  // spheres: 12 divisions in the fit against 32 in the references
  CHECK_THAT(found.fits[1].model.law.shelter, WithinAbs(1.1, 5e-3));
  CHECK(found.fits[0].errors[0].in_sample < 1e-6);
  CHECK(found.fits[0].errors[0].left_out_pose < 1e-6);
  CHECK(std::isnan(found.fits[0].errors[0].left_out_shape));  // there is one shape only
  CHECK(found.fits[1].errors[0].in_sample < 5e-3);
  CHECK(found.fits[1].errors[0].note > 0.05);
  CHECK_THROWS_WITH(calibrate_class_laws({records[0]}), Catch::Contains("at least"));
}

TEST_CASE("the boundary layer is found again from references below Re 200", "[compare][calibration][analytic]") {
  const auto with_layer = [](dragcore::Law law) {
    law.stokes = 1.0, law.layer = 1.2, law.layer_curvature = 0.6;
    return law;
  };
  const dragcore::Model truth{.law = with_layer(dragcore::closed_law()),
                              .sheets = dragcore::SheetModel{.law = with_layer(dragcore::sheet_law())}};
  std::vector<CaseRecord> records;
  const auto add = [&](const dragcore::Shape& shape, double reynolds, double incidence, double yaw) {
    CaseRecord record = made_by(truth, shape, incidence, yaw);  // of air without viscosity; now as it should be
    record.name = dragcore::kind(shape) + std::to_string(records.size()) + "_re-1e1-laminar_medium";
    record.reynolds = reynolds;
    record.viscosity = dragcore::properties(shape).reference_length / reynolds;
    record.flow_model = "laminar";
    record.load.force_pressure = predict(record, truth).total().force;
    records.push_back(record);
  };
  for (const double reynolds : {1.0, 30.0, 100.0}) {
    add(dragcore::Sphere{}, reynolds, 0, 0);
    add(dragcore::Box{}, reynolds, 0, 30);
    add(dragcore::Plate{}, reynolds, 40, 0);
  }
  add(dragcore::Box{}, 100, 0, 0);
  records.back().held_out = true;
  records.back().load.force_pressure *= 2.0;  // would spoil the fit

  const Fit fit = calibrate_viscous_terms(records).fits.front();
  CHECK(fit.cases.size() == 9);
  CHECK_THAT(fit.model.law.layer, WithinAbs(1.2, 6e-3));  // spheres: 12 divisions in the fit against 32 in the references
  CHECK_THAT(fit.model.law.layer_curvature, WithinAbs(0.6, 2e-2));
  CHECK(fit.model.sheets->law.layer == fit.model.law.layer);
  CHECK_THROWS_WITH(calibrate_viscous_terms({records[0]}), Catch::Contains("low_reynolds"));
}
