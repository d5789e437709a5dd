#include "compare/store/surface_patches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace compare {
namespace {

using Eigen::Vector3d;

constexpr double closure_tolerance = 1e-3;  // faces are written with 6+ digits; sample and forces of different iterations differ by more

std::string axis_face(const Vector3d& normal) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return std::string{"xyz"[axis], normal[axis] < 0 ? '-' : '+'};
}

std::string curved_bin(const Vector3d& centre, const dragcore::ShapeProperties& body) {
  constexpr int bands = 4, sectors = 8;
  const int band = std::clamp(static_cast<int>(std::floor(bands * (centre.x() - body.nose_x) / body.length_x)), 0, bands - 1);
  const double turn = std::atan2(centre.z(), centre.y()) / (2.0 * std::numbers::pi);
  const int sector = std::clamp(static_cast<int>(std::floor(sectors * (turn < 0 ? turn + 1.0 : turn))), 0, sectors - 1);
  return fmt::format("curved_b{}_s{}", band, sector);
}

/// The patch that a face of the meshed surface belongs to: by its normal on flat sides, by its place on curved ones.
std::string patch_name(const dragcore::Shape& shape, const dragcore::ShapeProperties& body, const Vector3d& centre,
                       const Vector3d& normal) {
  constexpr double along_axis = 0.9;  // ends are square to the axis; the side of a cylinder has 0, of a cone a negative x component
  if (std::holds_alternative<dragcore::Plate>(shape) || std::holds_alternative<dragcore::Box>(shape)) return axis_face(normal);
  if (std::holds_alternative<dragcore::Cylinder>(shape) && std::abs(normal.x()) > along_axis) return axis_face(normal);
  if (std::holds_alternative<dragcore::Prism>(shape))
    return std::max(std::abs(normal.y()), normal.x()) > along_axis ? axis_face(normal) : normal.z() < 0 ? "z-" : "z+";
  if (std::holds_alternative<dragcore::Cone>(shape) && normal.x() > along_axis) return "base";
  return curved_bin(centre, body);
}

/// The axis (1: y, 2: z) square to the symmetry plane of a half model: the centroid of the body is the origin, so a half lies on one side
/// of it. A few faces may reach over: snappyHexMesh pulls some next to the plane across it, seen to 3 % of the half's width. Their area is
/// part of what is checked against the whole body's.
int mirror_axis(const CaseRecord& record) {
  constexpr double overlap = 0.05;
  for (const int axis : {1, 2}) {
    const auto side = record.surface.centre.row(axis);
    const double below = std::max(0.0, -side.minCoeff()), above = std::max(0.0, side.maxCoeff());
    if (std::min(below, above) <= overlap * std::max(below, above)) return axis;
  }
  throw std::runtime_error(record.name +
                           ": a half model, but its surface lies on both sides of y = 0 and of z = 0; the sample is not its half");
}

struct Sums {
  double area = 0.0, pressure = 0.0;
  Vector3d area_centre = Vector3d::Zero(), area_vector = Vector3d::Zero(), friction = Vector3d::Zero();
  Vector3d pressure_centre = Vector3d::Zero(), pressure_force = Vector3d::Zero();
};

}  // namespace

std::string patch_of(const dragcore::Shape& shape, const Vector3d& centre, const Vector3d& normal) {
  return patch_name(shape, dragcore::properties(shape), centre, normal);
}

std::vector<PatchMean> patch_means(const CaseRecord& record) {
  const auto& sample = record.surface;
  const Eigen::Index faces = sample.centre.cols();
  if (faces == 0) return {};
  if (sample.area_vector.cols() != faces || sample.pressure_coefficient.size() != faces || sample.friction_coefficient.cols() != faces)
    throw std::runtime_error(record.name + ": the arrays of its surface sample differ in length; solve the case again");

  const dragcore::ShapeProperties body = dragcore::properties(record.shape);
  const Eigen::Matrix3d to_body = record.pose.rotation().transpose();
  std::vector<Vector3d> reflections = {Vector3d::Ones()};
  if (record.half_model) reflections.push_back(Vector3d::Ones() - 2.0 * Vector3d::Unit(mirror_axis(record)));

  std::map<std::string, Sums> patches;
  Vector3d force_wind = Vector3d::Zero();  // / q
  for (const Vector3d& reflection : reflections) {
    const Eigen::Matrix3d into_body = to_body * reflection.asDiagonal();
    for (Eigen::Index i = 0; i < faces; ++i) {
      const Vector3d centre = into_body * sample.centre.col(i);
      const Vector3d area_vector = into_body * sample.area_vector.col(i);
      const double area = area_vector.norm();
      if (area == 0.0) continue;
      const double c_p = sample.pressure_coefficient[i];
      Sums& sums = patches[patch_name(record.shape, body, centre, area_vector / area)];
      sums.area += area;
      sums.area_centre += area * centre;
      sums.area_vector += area_vector;
      sums.pressure += c_p * area;
      sums.pressure_centre += c_p * area * centre;
      sums.pressure_force -= c_p * area_vector;
      sums.friction += area * (into_body * sample.friction_coefficient.col(i));
      force_wind -= c_p * (reflection.asDiagonal() * sample.area_vector.col(i));
    }
  }

  const double q = 0.5 * record.density * record.speed * record.speed;
  const Vector3d expected = record.load_last.force_pressure;
  const double scale = std::max(expected.norm(), 0.05 * q * body.reference_area);
  if (const double gap = (q * force_wind - expected).norm() / scale; !(gap <= closure_tolerance))
    throw std::runtime_error(
        fmt::format("{}: the pressures on its surface add up to ({:.6g}, {:.6g}, {:.6g}) N, its pressure force is ({:.6g}, {:.6g}, {:.6g}) "
                    "N: apart by {:.2g} "
                    "of the force, at most {:.0e} is accepted; sample and force are not of the same field, solve the case again",
                    record.name, q * force_wind.x(), q * force_wind.y(), q * force_wind.z(), expected.x(), expected.y(), expected.z(), gap,
                    closure_tolerance));

  std::vector<PatchMean> means;
  for (const auto& [name, sums] : patches) {
    PatchMean mean;
    mean.name = name;
    mean.area = sums.area;
    mean.centroid = sums.area_centre / sums.area;
    mean.area_vector = sums.area_vector;
    mean.pressure_coefficient = sums.pressure / sums.area;
    mean.friction_coefficient = sums.friction / sums.area;
    mean.pressure_moment = sums.pressure_centre - sums.pressure * mean.centroid;
    mean.pressure_force = sums.pressure_force;
    means.push_back(std::move(mean));
  }
  return means;
}

}  // namespace compare
