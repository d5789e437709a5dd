#include "compare/reference/coefficients.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace compare {

using Eigen::Vector3d;

std::string symbol(Channel channel) {
  constexpr std::array<const char*, 7> symbols = {"C_D", "C_S", "C_L", "C_l", "C_m", "C_n", "x_cp"};
  return symbols[static_cast<std::size_t>(channel)];
}

case_record::CaseRecord::Channels coefficient_scales(const case_record::CaseRecord& record) {
  const dragcore::ShapeProperties body = dragcore::properties(record.shape);
  const double force = 0.5 * record.density * record.speed * record.speed * body.reference_area;
  case_record::CaseRecord::Channels scales;
  scales << Vector3d::Constant(force), Vector3d::Constant(force * body.reference_length);
  return scales;
}

namespace {

/// Where the line of action cuts the body's x axis. A force F at (x, 0, 0) has the moment (0, -x F_z, x F_y).
std::optional<double> centre_of_pressure(const case_record::CaseRecord& record, const Vector3d& force_wind, const Vector3d& moment_wind) {
  constexpr double smallest_normal_force = 0.05;  // of the whole force: docs/conventions.md
  const Eigen::Matrix3d to_body = record.pose.rotation().transpose();
  const Vector3d across = (to_body * Vector3d::UnitX()).cross(Vector3d::UnitX());  // normal of the plane of wind and chord
  if (across.norm() < 1e-9 || !dragcore::mirror_symmetric(record.shape, across)) return std::nullopt;
  const Vector3d force = to_body * force_wind, moment = to_body * moment_wind;
  const double normal_squared = force.tail<2>().squaredNorm();
  if (std::sqrt(normal_squared) < smallest_normal_force * force.norm() || normal_squared == 0.0) return std::nullopt;
  const double x = (force.y() * moment.z() - force.z() * moment.y()) / normal_squared;
  const dragcore::ShapeProperties body = dragcore::properties(record.shape);
  return (x - body.nose_x) / body.length_x;
}

}  // namespace

Coefficients coefficients(const case_record::CaseRecord& record, const Vector3d& force_wind, const Vector3d& moment_wind) {
  case_record::CaseRecord::Channels load;
  load << force_wind, moment_wind;
  return {load.cwiseQuotient(coefficient_scales(record)), centre_of_pressure(record, force_wind, moment_wind)};
}

Coefficients coefficients(const case_record::CaseRecord& record) {
  Coefficients own = coefficients(record, record.load.force(), record.load.moment());
  own.known = record.known;
  if (!record.knows_force() || !record.knows_moment()) own.centre_of_pressure.reset();
  return own;
}

std::array<bool, 6> null_channels(const case_record::CaseRecord& record) {
  // A mirror plane that holds the wind keeps the force in the plane and the moment square to it.
  const Eigen::Matrix3d to_body = record.pose.rotation().transpose();
  const bool mirror_y = dragcore::mirror_symmetric(record.shape, to_body * Vector3d::UnitY());
  const bool mirror_z = dragcore::mirror_symmetric(record.shape, to_body * Vector3d::UnitZ());
  return {false, mirror_y, mirror_z, mirror_y || mirror_z, mirror_z, mirror_y};
}

}  // namespace compare
