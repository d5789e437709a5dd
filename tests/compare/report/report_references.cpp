// Writes the references that the test of the report opens: loads made by a law with known coefficients, so that the page's numbers are
// known too. Usage: report_references FILE [failed] With `failed`, every case has diverged.

#include <cmath>
#include <iostream>
#include <numbers>
#include <string>

#include "compare/calibration/prediction.hpp"
#include "compare/store/store.hpp"

namespace {

using case_record::CaseRecord;
using case_record::Status;

constexpr double deg = std::numbers::pi / 180.0;
const dragcore::Model truth{.law = dragcore::scaled_law(0.9, 0.3), .pillow = {dragcore::PillowForm::tilt, 0.75}};

CaseRecord record(const dragcore::Shape& shape, double incidence_deg, double yaw_deg, double reynolds, const std::string& level,
                  int cells) {
  CaseRecord result;
  const bool by_yaw = dragcore::kind(shape) == "cube";
  result.name = dragcore::kind(shape) + (by_yaw ? "_yaw-" : "_incidence-") +
                std::to_string(static_cast<int>(by_yaw ? yaw_deg : incidence_deg)) + (reynolds > 1e3 ? "_re-1e5_" : "_re-1e2_") + level;
  result.key = result.description = result.name;
  result.source = "drag law";
  result.tier = "quick";
  result.shape = shape;
  result.pose = {.incidence = incidence_deg * deg, .yaw = yaw_deg * deg};
  result.reynolds = reynolds;
  result.flow_model = reynolds > 1e3 ? "k_omega_sst" : "laminar";
  result.mesh_level = level;
  result.viscosity = 1.0 / reynolds;
  result.status = Status::steady;
  result.iterations = 200;
  result.averaged_over = 50;
  result.cells = cells;
  const double force_scale = 0.5 * dragcore::properties(shape).reference_area;
  result.u_iteration.setConstant(0.01 * force_scale);
  result.u_iteration.tail<3>().setConstant(0.002 * force_scale);
  result.cost = {
      {"mesh", {1e-4 * cells, 1e-4 * cells}}, {"convert", {5e-5 * cells, 5e-5 * cells}}, {"solve", {1.5e-3 * cells, 1.5e-3 * cells}}};
  result.tools = {{"law", "scaled 0.9, 0.3"}};
  result.finished = "2020-01-01T00:00:00Z";
  const dragcore::Wrench wrench = compare::predict(result, truth).total();
  // Coarser meshes are wrong by a second-order error, so that the order found is known as well.
  const double mesh_error = 1.0 + 0.02 * std::pow(12e3 / cells, 2.0 / 3.0);
  result.load.force_pressure = mesh_error * wrench.force;
  result.load.moment_pressure = mesh_error * wrench.torque;
  result.load_last = result.load;
  return result;
}

/// The law's own pressure on the planar patches of a body.
std::vector<compare::PatchMean> patches(const CaseRecord& record) {
  std::vector<compare::PatchMean> means;
  if (!case_record::is_usable(record.status)) return means;
  const dragcore::Surface surface(dragcore::triangulate(record.shape, compare::default_divisions(record.shape)));
  const Eigen::Vector3d flow = record.pose.rotation().transpose() * Eigen::Vector3d::UnitX();
  for (const dragcore::Patch& patch : surface.patches) {
    if (patch.area < 0.01) continue;  // a triangle of a curved side is no planar face
    compare::PatchMean mean;
    const double c = -flow.dot(patch.normal);
    mean.name = compare::patch_of(record.shape, patch.centroid, patch.normal);
    mean.area = patch.area;
    mean.centroid = patch.centroid;
    mean.area_vector = patch.area * patch.normal;
    mean.pressure_coefficient = c > 0.0 ? dragcore::evaluate(truth.law.windward, c) : -dragcore::evaluate(truth.law.leeward, -c);
    mean.pressure_force = -mean.pressure_coefficient * mean.area_vector;
    means.push_back(mean);
  }
  return means;
}

}  // namespace

int main(int argc, char** argv) {
  const bool all_failed = argc == 3 && std::string(argv[2]) == "failed";
  if (argc != 2 && !all_failed) {
    std::cerr << "usage: report_references FILE [failed]\n";
    return 2;
  }
  compare::Reference reference;
  auto& cases = reference.cases;
  for (int angle = 0; angle <= 90; angle += 15) cases.push_back(record(dragcore::Plate{}, angle, 0, 1e5, "medium", 12000));
  for (int angle = 0; angle <= 45; angle += 15) cases.push_back(record(dragcore::Box{}, 0, angle, 1e5, "medium", 12000));
  for (int angle = 0; angle <= 180; angle += 30) cases.push_back(record(dragcore::Cone{}, angle, 0, 1e5, "medium", 12000));
  cases.push_back(record(dragcore::Box{}, 0, 0, 1e5, "coarse", 4000));
  cases.push_back(record(dragcore::Box{}, 0, 0, 1e5, "fine", 36000));
  cases.push_back(record(dragcore::Sphere{}, 0, 0, 100, "medium", 12000));
  cases.push_back(record(dragcore::Plate{.span = 2.0}, 30, 0, 100, "medium", 12000));
  cases.push_back(record(dragcore::Plate{.span = 2.0}, 90, 0, 100, "medium", 12000));
  for (CaseRecord& failed : cases)
    if (all_failed || failed.name == "cone_incidence-150_re-1e5_medium") {
      failed.status = Status::diverged;
      failed.reason = "C_D -2e4 after 37 iterations <seeded>";
      failed.load = failed.load_last = {};
    }
  for (const CaseRecord& each : cases) reference.patches.push_back(patches(each));
  compare::write_reference(argv[1], reference, "test");
}
