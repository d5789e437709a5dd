#pragma once

#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <dragcore/drag.hpp>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "compare/calibration/prediction.hpp"
#include "compare/case_record/case_record.hpp"
#include "compare/reference/coefficients.hpp"

/// Case records made by code: inputs of tests, not results. Their flow is a formula, so that every expected value can be worked out.
namespace sample {

using case_record::CaseRecord;
constexpr double deg = std::numbers::pi / 180.0;

/// The wall as triangles in the wind frame, with C_p = 2 c^2 - 0.5 on every face (c the cosine between flow and inward normal, 0 leeward)
/// and a constant shear along the wind.
inline case_record::SurfaceSample surface(const dragcore::Shape& shape, const dragcore::Pose& pose, int divisions = 4) {
  const dragcore::TriangleMesh mesh = dragcore::triangulate(shape, divisions);
  const auto faces = static_cast<Eigen::Index>(mesh.triangles.size());
  case_record::SurfaceSample sample{Eigen::Matrix3Xd(3, faces), Eigen::Matrix3Xd(3, faces), Eigen::VectorXd(faces),
                                    Eigen::Matrix3Xd(3, faces)};
  const Eigen::Matrix3d to_wind = pose.rotation();
  for (Eigen::Index i = 0; i < faces; ++i) {
    const auto& t = mesh.triangles[static_cast<std::size_t>(i)];
    const Eigen::Vector3d a = to_wind * mesh.vertices[static_cast<std::size_t>(t[0])],
                          b = to_wind * mesh.vertices[static_cast<std::size_t>(t[1])],
                          c = to_wind * mesh.vertices[static_cast<std::size_t>(t[2])];
    sample.centre.col(i) = (a + b + c) / 3.0;
    sample.area_vector.col(i) = 0.5 * (b - a).cross(c - a);
    const double cosine = std::max(0.0, -sample.area_vector.col(i).normalized().x());
    sample.pressure_coefficient[i] = 2.0 * cosine * cosine - 0.5;
    sample.friction_coefficient.col(i) = Eigen::Vector3d(0.01, 0.0, 0.0);
  }
  return sample;
}

/// A steady case whose loads follow from surface().
inline CaseRecord record(const std::string& stem, const dragcore::Shape& shape, const dragcore::Pose& pose,
                         const std::string& level = "medium", int cells = 12000) {
  CaseRecord r;
  r.name = stem + "_" + level;
  r.key = std::string(56, 'k') + std::to_string(10000000 + std::hash<std::string>{}(r.name) % 89999999);
  r.description = R"({"made_by":"test"})";
  r.source = "formula";
  r.tier = "quick";
  r.shape = shape;
  r.pose = pose;
  r.reynolds = 1e5;
  r.flow_model = "k_omega_sst";
  r.mesh_level = level;
  r.density = 1.2;
  r.speed = 2.0;
  r.viscosity = r.speed * dragcore::properties(shape).reference_length / r.reynolds;
  r.status = case_record::Status::steady;
  r.attempts = {{"standard", case_record::Status::drifting, "slow"}, {"cautious", case_record::Status::steady, ""}};
  r.surface = surface(shape, pose);
  const double q = 0.5 * r.density * r.speed * r.speed;
  for (Eigen::Index i = 0; i < r.surface.centre.cols(); ++i) {
    const Eigen::Vector3d pressure = -q * r.surface.pressure_coefficient[i] * r.surface.area_vector.col(i);
    const Eigen::Vector3d shear = q * r.surface.friction_coefficient.col(i) * r.surface.area_vector.col(i).norm();
    r.load.force_pressure += pressure;
    r.load.force_viscous += shear;
    r.load.moment_pressure += r.surface.centre.col(i).cross(pressure);
    r.load.moment_viscous += r.surface.centre.col(i).cross(shear);
  }
  r.load_last = r.load;
  r.iterations = 240;
  r.averaged_over = 60;
  r.u_iteration.setConstant(0.003);
  r.u_statistical.setConstant(0.004);
  r.cells = cells;
  r.mesh_quality = {{"max_non_orthogonality_deg", 61.5}, {"max_skewness", 1.7}};
  r.surface_area = dragcore::properties(shape).area;
  r.surface_volume = dragcore::properties(shape).volume;
  r.surface_checksum = "00ff";
  r.cost = {{"mesh", {2.5, 2.6}}, {"solve", {13.0, 13.5}}};
  r.tools = {{"openfoam", "1912"}, {"gmsh", "4.8.4"}};
  r.finished = "2026-01-02T03:04:05Z";
  return r;
}

/// A plate by incidence, a cube by yaw, a cone by incidence.
inline std::vector<CaseRecord> quick_tier() {
  std::vector<CaseRecord> records;
  const auto name = [](const char* stem, const char* angle, int value) {
    std::string digits = std::to_string(1000 + value).substr(1);
    return std::string(stem) + "_" + angle + "-" + digits + "_re-1e5";
  };
  for (int i = 0; i <= 90; i += 30) records.push_back(record(name("plate", "incidence", i), dragcore::Plate{}, {.incidence = i * deg}));
  for (int i = 0; i <= 45; i += 15) records.push_back(record(name("cube", "yaw", i), dragcore::Box{}, {.yaw = i * deg}));
  for (int i = 0; i <= 180; i += 60) records.push_back(record(name("cone", "incidence", i), dragcore::Cone{}, {.incidence = i * deg}));
  return records;
}

/// A body that spins in still air, with this coefficient of torque about its axis, a quarter of it by friction.
inline CaseRecord spinning(const std::string& stem, const dragcore::Shape& shape, const Eigen::Vector3d& omega_wind,
                           double torque_coefficient, double reynolds, const std::string& level = "medium", int cells = 12000) {
  CaseRecord r = record(stem, shape, {}, level, cells);
  r.still_air = true;
  r.angular_velocity = omega_wind;
  r.speed = omega_wind.norm() * dragcore::properties(shape).reference_length;
  r.reynolds = reynolds;
  r.flow_model = "laminar";
  r.held_out = true;
  r.load = {};
  const Eigen::Vector3d moment = torque_coefficient * compare::coefficient_scales(r)[3] * omega_wind.normalized();
  r.load.moment_pressure = 0.75 * moment;
  r.load.moment_viscous = 0.25 * moment;
  r.load_last = r.load;
  r.surface = {};  // of another flow
  r.u_iteration.setZero();
  r.u_statistical.setZero();
  return r;
}

/// A folder of its own for one test, removed at its end.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "dragval-test-XXXXXX").string();
    if (!::mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path_); }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace sample
