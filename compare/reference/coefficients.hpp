#pragma once

#include <array>
#include <optional>
#include <string>

#include "compare/case_record/case_record.hpp"

namespace compare {

/// What is compared. The first six are in the order of CaseRecord::Channels, forces then moments; definitions in docs/conventions.md.
enum class Channel { drag, side, lift, roll, pitch, yaw, centre_of_pressure };
constexpr std::array<Channel, 7> all_channels = {
    Channel::drag, Channel::side, Channel::lift, Channel::roll, Channel::pitch, Channel::yaw, Channel::centre_of_pressure};
std::string symbol(Channel channel);  ///< "C_D", "C_S", "C_L", "C_l", "C_m", "C_n", "x_cp"

/// Dimensionless load on a body: C_D, C_S, C_L, C_l, C_m, C_n, and the centre of pressure where it is defined.
struct Coefficients {
  case_record::CaseRecord::Channels values = case_record::CaseRecord::Channels::Zero();
  std::optional<double> centre_of_pressure;  ///< from the nose, in units of the length along the body's x axis
  std::array<bool, 6> known = {true, true, true, true, true, true};  ///< whether `values` has anything to say

  /// Empty where it is not defined, or nobody measured it.
  std::optional<double> operator[](Channel channel) const {
    if (channel == Channel::centre_of_pressure) return centre_of_pressure;
    const auto index = static_cast<std::size_t>(channel);
    return known[index] ? std::optional<double>(values[static_cast<Eigen::Index>(index)]) : std::nullopt;
  }
};

/// From force [N] and moment about the centroid [N m], both in the wind frame, at the pose, speed and density of the case.
Coefficients coefficients(const case_record::CaseRecord& record, const Eigen::Vector3d& force_wind, const Eigen::Vector3d& moment_wind);

/// Of the case's own mean load, as far as it is known: a centre of pressure takes a whole force and moment.
Coefficients coefficients(const case_record::CaseRecord& record);

/// q A_ref for forces, q A_ref L_ref for moments: divide SI channels by this to get coefficients.
case_record::CaseRecord::Channels coefficient_scales(const case_record::CaseRecord& record);

/// Channels that a mirror plane of body and wind makes zero: bit i of CaseRecord::Channels.
std::array<bool, 6> null_channels(const case_record::CaseRecord& record);

}  // namespace compare
