#pragma once

#include <cstdint>
#include <dragcore/wind.hpp>

namespace dragcore {

/// Parameters of Dryden turbulence. Components are along the mean wind (u), to its starboard (v) and up (w), y = z x x as in the wind
/// frame.
struct Dryden {
  std::uint64_t seed = 0;
  Eigen::Vector3d intensity = Eigen::Vector3d::Ones();        ///< standard deviations sigma_u, sigma_v, sigma_w, >= 0 [m/s]
  Eigen::Vector3d length = Eigen::Vector3d::Constant(533.4);  ///< scale lengths L_u, L_v, L_w > 0, in the sense of MIL-F-8785C [m]
  Eigen::Vector3d mean_wind =
      Eigen::Vector3d(10.0, 0.0, 0.0);  ///< carries the eddies past; zero leaves them in place, with u along x [m/s]
  int waves = 192;                      ///< multiple of 3; cost of a sample grows with it
};

/// Scale lengths and intensities of MIL-F-8785C below 1000 ft: L_w = h, L_u = L_v = h / (0.177 + 0.000823 h)^1.2, sigma_w = 0.1 W20,
/// sigma_u = sigma_v = sigma_w / (0.177 + 0.000823 h)^0.4, with h in feet. MIL-HDBK-1797 defines L_v and L_w as half of these and doubles
/// them in its spectra: the same turbulence.
/// @param height             above ground, 10 to 1000 ft (3.048 to 304.8 m)
/// @param wind_speed_at_20ft W20, at 6.096 m above ground [m/s]; also the mean wind that carries the eddies, along x unless you turn it
/// @throws std::invalid_argument  outside these ranges: above, set intensity and length (533.4 m) oneself
Dryden low_altitude_dryden(double height, double wind_speed_at_20ft);

/// One-sided spectra over the spatial frequency W [rad/m], integral sigma^2 [m^3/s^2 per rad]:
///   u:     2 sigma^2 L / pi / (1 + (L W)^2)        v, w:  sigma^2 L / pi (1 + 3 (L W)^2) / (1 + (L W)^2)^2
double dryden_longitudinal_spectrum(double sigma, double length, double frequency);
double dryden_transverse_spectrum(double sigma, double length, double frequency);

/// Frozen turbulence carried by the mean wind, as a pure function of (seed, place, time): no state, no step, no period.
///
/// A sum of plane waves a cos(k.x/L + phi) with a normal to k, wavenumbers at random within equal shares of the energy of the isotropic
/// spectrum
///   E(k) = sigma^2 (8 L / pi) (L k)^4 / (1 + (L k)^2)^3,
/// whose one-dimensional spectra along any line are Dryden's for u, v and w. Over all seeds spectrum and covariance are exact up to the
/// wavenumber 0.57 waves / L; the energy beyond, a share of 3 / waves, sits at one wavenumber, so that the velocity is smooth. Each seed by
/// itself has the exact variance over long times. Free of divergence where all lengths and intensities are equal; near the ground, where
/// they differ, each component keeps its own spectrum along the mean wind.
///
/// @accuracy  phase error 1e-16 |x - U t| / L: 1e-7 rad after 1e9 s at 10 m/s
/// @source    spectra: [mil_f_8785c] sec. 3.7; sum of waves: [kraichnan_1970]; differs: stratified wavenumbers, three waves on each
/// orthonormal frame
class Turbulence {
 public:
  /// @throws std::invalid_argument  on a value out of the ranges above
  explicit Turbulence(const Dryden& parameters);

  const Dryden& parameters() const { return parameters_; }
  Eigen::Vector3d velocity(const Eigen::Vector3d& point, double time) const;
  WindSample sample(const Eigen::Vector3d& point, double time) const;

  /// Many points, 3 x n, one column each, all at one time. A point's velocity does not depend on the points beside it.
  /// @accuracy  velocity() to 1e-14 of the intensity, plus the error of the phase: in double precision, 8 or 4 points at once where the
  ///            library was built with kernels (DRAGCORE_SIMD)
  Eigen::Matrix3Xd velocities(const Eigen::Ref<const Eigen::Matrix3Xd>& points, double time) const;

  /// Four standard deviations of the ensemble at the given distance: a statistical bound, the same at every place and time.
  FieldVariation variation(double radius) const;

 private:
  template <bool with_gradient>
  WindSample evaluate(const Eigen::Vector3d& point, double time) const;

  Dryden parameters_;
  Eigen::Matrix3d axes_;          ///< columns u, v, w
  Eigen::Matrix3Xd wavevectors_;  ///< times L
  Eigen::Matrix3Xd amplitudes_;   ///< for unit intensity
  Eigen::VectorXd phases_;
};

}  // namespace dragcore
