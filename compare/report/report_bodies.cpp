#include "compare/report/report_bodies.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "compare/report/report_sweep.hpp"

namespace compare {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

/// Of round bodies: fine enough to look round, coarse enough for a page.
constexpr int shown_divisions = 8;

std::vector<double> numbers(const Eigen::MatrixXd& matrix) { return {matrix.data(), matrix.data() + matrix.size()}; }

/// Mean over each patch of the pressure that a model has in its normal forces; patches that the model's surface misses have none.
std::map<std::string, double> patch_pressures(const CaseRecord& record, const ModelChoice& choice) {
  const dragcore::Surface& surface = prepared_surface(record.shape, std::min(shown_divisions, default_divisions(record.shape)));
  const auto forces = dragcore::triangle_forces(surface, motion_of(record), medium_of(record), choice.on(surface));
  const double q = 0.5 * record.density * record.speed * record.speed;
  std::map<std::string, std::pair<double, double>> sums;  // of the normal force, of the area
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Vector3d normal = surface.normal.row(i), centre = surface.centroid.row(i);
    auto& [push, area] = sums[patch_of(record.shape, centre, normal)];
    push -= normal.dot(forces.force.col(i));
    area += surface.area[i];
  }
  std::map<std::string, double> means;
  for (const auto& [name, sum] : sums) means[name] = sum.first / (q * sum.second);
  return means;
}

/// The shape as the page draws it.
json drawn_shape(const CaseRecord& record, const std::vector<PatchMean>& patches) {
  const dragcore::TriangleMesh mesh = dragcore::triangulate(record.shape, std::min(shown_divisions, default_divisions(record.shape)));
  json drawn = {{"name", shape_label(record.shape)},
                {"vertices", json::array()},
                {"triangles", json::array()},
                {"patch", json::array()},
                {"patches", json::array()}};
  for (const PatchMean& patch : patches) drawn["patches"].push_back(patch.name);
  for (const Vector3d& vertex : mesh.vertices)
    for (const double x : vertex) drawn["vertices"].push_back(x);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (const int corner : t) drawn["triangles"].push_back(corner);
    const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const std::string name = patch_of(record.shape, (a + b + c) / 3.0, (b - a).cross(c - a).normalized());
    const auto found = std::find_if(patches.begin(), patches.end(), [&](const PatchMean& patch) { return patch.name == name; });
    drawn["patch"].push_back(found == patches.end() ? -1 : static_cast<int>(found - patches.begin()));
  }
  return drawn;
}

json pressures_of_model(const CaseRecord& record, const std::vector<PatchMean>& patches, const std::string& label,
                        const ModelChoice& choice) {
  const auto means = patch_pressures(record, choice);
  double area = 0.0, gap = 0.0;
  for (const PatchMean& patch : patches)
    if (const auto mean = means.find(patch.name); mean != means.end()) {
      area += patch.area;
      gap += patch.area * (mean->second - patch.pressure_coefficient);
    }
  const double gauge = area > 0.0 ? gap / area : 0.0;
  json pressures = json::array();
  for (const PatchMean& patch : patches) {
    const auto mean = means.find(patch.name);
    pressures.push_back(mean == means.end() ? json(nullptr) : json(mean->second - gauge));
  }
  const dragcore::Wrench wrench = predict(record, choice).total();
  return {{"label", label},
          {"pressures", pressures},
          {"gauge", gauge},
          {"coefficients", numbers(coefficients(record, wrench.force, wrench.torque).values)}};
}

json drawn_cases(const Report& report, json& shapes) {
  std::map<std::string, std::size_t> shape_index;
  std::map<std::string, const ErrorRow*> of_record;
  for (const ErrorRow& row : report.models.front().table.rows)
    if (row.channel == Channel::drag) of_record[row.case_name] = &row;
  json cases = json::array();
  for (std::size_t i = 0; i < std::min(report.reference.cases.size(), report.reference.patches.size()); ++i) {
    const CaseRecord& record = report.reference.cases[i];
    const auto& patches = report.reference.patches[i];
    const auto row = of_record.find(record.name);
    if (patches.empty() || row == of_record.end() || !case_record::is_usable(record.status)) continue;
    const std::string shape = shape_label(record.shape);
    // Coarse meshes may miss a patch, so the names of one case need not be those of another.
    std::string key = shape;
    for (const PatchMean& patch : patches) key += " " + patch.name;
    const auto [known, fresh] = shape_index.try_emplace(key, shapes.size());
    if (fresh) shapes.push_back(drawn_shape(record, patches));
    json pressures = json::array();
    for (const PatchMean& patch : patches) pressures.push_back(patch.pressure_coefficient);
    json models = json::array();
    models.push_back(pressures_of_model(record, patches, "law by class", ModelChoice::recommended()));
    models.push_back(pressures_of_model(record, patches, "note's law", dragcore::Model{}));
    cases.push_back({{"case", record.name},
                     {"shape", known->second},
                     {"flow", shape + " at Re " + reynolds_text(record.reynolds) +
                                  (row->second->flow_class == "k_omega_sst" ? ", k-\u03c9 SST" : ", " + row->second->flow_class)},
                     {"pose", pose_text(*row->second)},
                     {"rotation", numbers(record.pose.rotation().transpose())},  // row by row
                     {"length", dragcore::properties(record.shape).reference_length},
                     {"pressures", pressures},
                     {"coefficients", numbers(coefficients(record).values)},
                     {"u", row->second->u},
                     {"models", models}});
  }
  return cases;
}

/// What the laws err by, of C_D, for a body of a class in a range of Re.
json expected_errors(const Report& report) {
  constexpr double ends[] = {0.0, 3.0, 30.0, 200.0, 1e4, 1e9};
  std::map<std::string, const CaseRecord*> records;
  for (const CaseRecord& record : report.reference.cases) records[record.name] = &record;
  struct Sum {
    int n = 0;
    double squares = 0.0;
  };
  std::map<std::tuple<std::string, std::string, std::size_t, bool>, Sum> sums;
  for (const ReportedModel& model : report.models) {
    if (model.pillow != "none") continue;  // moves the force, and does not change it
    for (const ErrorRow& row : model.table.rows) {
      const auto record = records.find(row.case_name);
      if (row.channel != Channel::drag || !row.relative_error || record == records.end()) continue;
      const dragcore::Shape& shape = record->second->shape;
      const auto& surface = prepared_surface(shape, std::min(shown_divisions, default_divisions(shape)));
      const auto range = static_cast<std::size_t>(std::upper_bound(std::begin(ends), std::end(ends), row.reynolds) - std::begin(ends)) - 1;
      Sum& sum = sums[{model.law, to_string(surface.body_class), range, row.held_out}];
      ++sum.n;
      sum.squares += *row.relative_error * *row.relative_error;
    }
  }
  json errors = json::array();
  for (const auto& [key, sum] : sums) {
    const auto& [law, body_class, range, held_out] = key;
    errors.push_back({{"law", law},
                      {"class", body_class},
                      {"from", ends[range]},
                      {"to", ends[range + 1]},
                      {"unseen", held_out},
                      {"n", sum.n},
                      {"rms", std::sqrt(sum.squares / sum.n)}});
  }
  return errors;
}

}  // namespace

json report_bodies(const Report& report) {
  json shapes = json::array();
  json cases = drawn_cases(report, shapes);
  return {{"shapes", shapes}, {"cases", cases}, {"errors", expected_errors(report)}};
}

}  // namespace compare
