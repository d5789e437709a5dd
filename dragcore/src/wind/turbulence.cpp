#include <Eigen/Geometry>
#include <cmath>
#include <dragcore/turbulence.hpp>
#include <numbers>
#include <random>

#include "support/require.hpp"
#include "wind/batch_kernels.hpp"

namespace dragcore {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// The wavenumber, in units of 1/L, below which lies the given share of the energy. With k = tan(t) the share is
/// 16/(3 pi) int_0^t sin^4 = 16/(3 pi) (3t/8 - sin(2t)/4 + sin(4t)/32), increasing: bisection to the last bit.
double wavenumber_below_which(double share) {
  double low = 0.0, high = 0.5 * pi;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.5 * (low + high);
    (16.0 / (3.0 * pi) * (0.375 * t - 0.25 * std::sin(2.0 * t) + std::sin(4.0 * t) / 32.0) < share ? low : high) = t;
  }
  return std::tan(0.5 * (low + high));
}

}  // namespace

double dryden_longitudinal_spectrum(double sigma, double length, double frequency) {
  return 2.0 * sigma * sigma * length / pi / (1.0 + std::pow(length * frequency, 2));
}

double dryden_transverse_spectrum(double sigma, double length, double frequency) {
  const double x2 = std::pow(length * frequency, 2);
  return sigma * sigma * length / pi * (1.0 + 3.0 * x2) / ((1.0 + x2) * (1.0 + x2));
}

Dryden low_altitude_dryden(double height, double wind_speed_at_20ft) {
  constexpr double foot = 0.3048;
  // The limits in metres as written carry a rounding error when they come from feet.
  require(height >= 10.0 * foot * (1 - 1e-12) && height <= 1000.0 * foot * (1 + 1e-12), "Dryden turbulence: height", height,
          "the low-altitude model holds from 3.048 to 304.8 m");
  require(wind_speed_at_20ft >= 0.0 && std::isfinite(wind_speed_at_20ft), "Dryden turbulence: wind speed at 20 ft", wind_speed_at_20ft,
          "it must be finite and not negative");
  const double base = 0.177 + 0.000823 * height / foot, horizontal_length = height / std::pow(base, 1.2);
  const double sigma_w = 0.1 * wind_speed_at_20ft, sigma_u = sigma_w / std::pow(base, 0.4);
  return {.intensity = {sigma_u, sigma_u, sigma_w},
          .length = {horizontal_length, horizontal_length, height},
          .mean_wind = {wind_speed_at_20ft, 0.0, 0.0}};
}

Turbulence::Turbulence(const Dryden& parameters) : parameters_(parameters) {
  const auto& [seed, intensity, length, mean_wind, waves] = parameters_;
  require(intensity.allFinite() && (intensity.array() >= 0.0).all(), "Dryden turbulence: intensity", intensity,
          "it must be finite and not negative");
  require(length.allFinite() && (length.array() > 0.0).all(), "Dryden turbulence: length", length,
          "it must be finite and greater than 0 m");
  require_finite("Dryden turbulence: mean wind", mean_wind);
  require(waves >= 3 && waves <= 3'000'000 && waves % 3 == 0, "Dryden turbulence: waves", waves,
          "it must be a multiple of 3, from 3 to 3,000,000");

  axes_.setIdentity();
  if (mean_wind.stableNorm() > 0.0) {
    const Vector3d u = mean_wind.stableNormalized();
    // Up is z; a wind that blows along z has no up, and takes -x, the limit of a climbing wind along x.
    const Vector3d w_raw = Vector3d::UnitZ() - u[2] * u;
    const Vector3d w = w_raw.norm() > 1e-6
                           ? w_raw.normalized()
                           : (Vector3d::UnitX() * (u[2] > 0.0 ? -1.0 : 1.0) - u * (u[0] * (u[2] > 0.0 ? -1.0 : 1.0))).normalized();
    axes_ << u, w.cross(u), w;
  }

  // The engine's sequence is fixed by the standard, the library's distributions are not: uniforms are made here.
  std::mt19937_64 engine(seed);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  wavevectors_.resize(3, waves);
  amplitudes_.resize(3, waves);
  phases_.resize(waves);
  const int frames = waves / 3;
  for (int n = 0; n < frames; ++n) {
    // A share of the energy per frame, the wavenumber at random in it; the last one has no end, and takes its median.
    const double draw = uniform(), k = wavenumber_below_which((n + (n + 1 < frames ? draw : 0.5)) / frames);
    // A uniformly random rotation by its quaternion. Wavevectors along its axes, amplitudes along the next axis: each component has the
    // same energy in every draw.
    const double r = uniform(), a = 2.0 * pi * uniform(), b = 2.0 * pi * uniform();
    const double inner = std::sqrt(1.0 - r), outer = std::sqrt(r);
    const Matrix3d frame =
        Eigen::Quaterniond(outer * std::cos(b), inner * std::sin(a), inner * std::cos(a), outer * std::sin(b)).toRotationMatrix();
    for (int i = 0; i < 3; ++i) {
      wavevectors_.col(3 * n + i) = k * frame.col(i);
      amplitudes_.col(3 * n + i) = std::sqrt(6.0 / waves) * frame.col((i + 1) % 3);
      phases_[3 * n + i] = 2.0 * pi * uniform();
    }
  }
}

template <bool with_gradient>
WindSample Turbulence::evaluate(const Vector3d& point, double time) const {
  const Vector3d place = axes_.transpose() * (point - parameters_.mean_wind * time);
  const Vector3d length = parameters_.length;
  WindSample local;
  for (Eigen::Index n = 0; n < phases_.size(); ++n) {
    const double along = wavevectors_.col(n).dot(place);
    for (int i = 0; i < 3; ++i) {
      const double phase = along / length[i] + phases_[n];
      local.velocity[i] += amplitudes_(i, n) * std::cos(phase);
      if constexpr (with_gradient)
        local.gradient.row(i) -= amplitudes_(i, n) * std::sin(phase) / length[i] * wavevectors_.col(n).transpose();
    }
  }
  const Matrix3d turn = axes_ * parameters_.intensity.asDiagonal();
  return {turn * local.velocity, turn * local.gradient * axes_.transpose()};
}

Vector3d Turbulence::velocity(const Vector3d& point, double time) const { return evaluate<false>(point, time).velocity; }

Eigen::Matrix3Xd Turbulence::velocities(const Eigen::Ref<const Eigen::Matrix3Xd>& points, double time) const {
  Eigen::Matrix3Xd result(3, points.cols());
  const Eigen::Matrix3Xd places = axes_.transpose().lazyProduct(points.colwise() - parameters_.mean_wind * time);
  const Waves waves{wavevectors_.data(), amplitudes_.data(), phases_.data(), static_cast<std::size_t>(phases_.size()),
                    parameters_.length.data()};
  if (sum_of_waves(waves, places.data(), static_cast<std::size_t>(places.cols()), result.data())) {
    const Matrix3d turn = axes_ * parameters_.intensity.asDiagonal();
    for (auto velocity : result.colwise()) velocity = turn * Vector3d(velocity);
  } else {
    for (Eigen::Index i = 0; i < points.cols(); ++i) result.col(i) = velocity(points.col(i), time);
  }
  return result;
}

WindSample Turbulence::sample(const Vector3d& point, double time) const { return evaluate<true>(point, time); }

FieldVariation Turbulence::variation(double radius) const {
  // Mean squares of one wave over random phase and direction, with q = k r / L:
  //   |e^{i k.r} - 1|^2 = 2 (1 - sin q / q),   |e^{i k.r} - 1 - i k.r|^2 = 2 + q^2/3 + 2 cos q - 4 sin q / q <= q^4/20,   |k.r|^2 = q^2/3.
  double constant = 0.0, affine = 0.0, slope = 0.0;
  for (Eigen::Index n = 0; n < phases_.size(); ++n)
    for (int i = 0; i < 3; ++i) {
      const double k = wavevectors_.col(n).norm() / parameters_.length[i], q = k * radius;
      const double energy =
          0.5 * std::pow(parameters_.intensity[i], 2) * 2.0 / static_cast<double>(phases_.size());  // a^2/2, averaged over directions
      constant += energy * (q < 1e-3 ? q * q / 3.0 : 2.0 * (1.0 - std::sin(q) / q));
      affine += energy * (q < 0.1 ? q * q * q * q / 20.0 : 2.0 + q * q / 3.0 + 2.0 * std::cos(q) - 4.0 * std::sin(q) / q);
      slope += energy * k * k / 3.0;
    }
  return {4.0 * std::sqrt(constant), 4.0 * std::sqrt(affine), 4.0 * std::sqrt(slope), 0.0};
}

}  // namespace dragcore
