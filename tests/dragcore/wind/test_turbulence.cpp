#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/turbulence.hpp>
#include <limits>
#include <numbers>
#include <random>

using namespace dragcore;
using Catch::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Integral over all frequencies, with W = tan(t)/L; the integrand is smooth in t and periodic, so the midpoint rule converges to rounding.
template <class Spectrum>
double integral(const Spectrum& spectrum, double length, double below = std::numeric_limits<double>::infinity()) {
  const double end = std::atan(below * length);
  double sum = 0.0;
  constexpr int points = 20'000;
  for (int i = 0; i < points; ++i) {
    const double t = end * (i + 0.5) / points;
    sum += spectrum(std::tan(t) / length) / (length * std::cos(t) * std::cos(t));
  }
  return sum * end / points;
}

/// Ensemble means over seeds and places of products of velocity components a distance apart.
Eigen::Matrix3d covariance(const Dryden& base, const Vector3d& apart) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-1e4, 1e4);
  constexpr int seeds = 600, places = 20;
  for (int s = 0; s < seeds; ++s) {
    Dryden parameters = base;
    parameters.seed = static_cast<std::uint64_t>(s);
    const Turbulence turbulence(parameters);
    for (int i = 0; i < places; ++i) {
      const Vector3d here(place(random), place(random), place(random));
      sum += turbulence.velocity(here, 0.0) * turbulence.velocity(here + apart, 0.0).transpose();
    }
  }
  return sum / (seeds * places);
}

// 12,000 nearly independent products of unit variance at most sqrt(2) wide: standard error 0.013; five of them.
constexpr double five_standard_errors = 0.065;

const Dryden unit{.intensity = {1.0, 1.0, 1.0}, .length = {100.0, 100.0, 100.0}, .waves = 48};

}  // namespace

TEST_CASE("the Dryden spectra hold the whole variance, and both military specifications mean the same one",
          "[dragcore][turbulence][analytic]") {
  const double sigma = 1.7, length = 300.0;
  CHECK_THAT(integral([&](double w) { return dryden_longitudinal_spectrum(sigma, length, w); }, length), WithinRel(sigma * sigma, 1e-12));
  CHECK_THAT(integral([&](double w) { return dryden_transverse_spectrum(sigma, length, w); }, length), WithinRel(sigma * sigma, 1e-8));
  // MIL-HDBK-1797, transverse: sigma^2 2 L / pi (1 + 12 (L W)^2) / (1 + 4 (L W)^2)^2 with its L half of MIL-F-8785C's.
  for (const double w : {1e-4, 3e-3, 0.1}) {
    const double half = 0.5 * length, x2 = std::pow(half * w, 2);
    CHECK_THAT(sigma * sigma * 2.0 * half / pi * (1 + 12 * x2) / std::pow(1 + 4 * x2, 2),
               WithinRel(dryden_transverse_spectrum(sigma, length, w), 1e-14));
  }
}

TEST_CASE("low-altitude lengths and intensities follow the specification", "[dragcore][turbulence][analytic]") {
  // At 1000 ft: 0.177 + 0.823 = 1, so that all lengths and intensities meet.
  const Dryden high = low_altitude_dryden(304.8, 15.0);
  CHECK((high.length - Vector3d::Constant(304.8)).norm() < 1e-9);
  CHECK((high.intensity - Vector3d::Constant(1.5)).norm() < 1e-12);
  // At 100 ft: 0.2593; L_u = 100 ft / 0.2593^1.2 = 505.22 ft, sigma_u / sigma_w = 0.2593^-0.4 = 1.7160.
  const Dryden low = low_altitude_dryden(30.48, 10.0);
  CHECK(low.length[2] == 30.48);
  CHECK_THAT(low.length[0] / 0.3048, WithinRel(100.0 / std::exp(1.2 * std::log(0.2593)), 1e-12));
  CHECK_THAT(low.intensity[0] / low.intensity[2], WithinRel(std::exp(-0.4 * std::log(0.2593)), 1e-12));
  CHECK_THAT(low.intensity[2], WithinRel(1.0, 1e-15));
  for (const double height : {0.0, 3.0, 305.0, std::nan("")}) CHECK_THROWS_WITH(low_altitude_dryden(height, 10.0), Contains("304.8"));
  CHECK_THROWS_WITH(low_altitude_dryden(100.0, -1.0), Contains("wind speed"));
}

TEST_CASE("turbulence has the covariance of Dryden's spectra, along and across the separation", "[dragcore][turbulence][analytic]") {
  // Longitudinal exp(-r/L), transverse exp(-r/L) (1 - r/(2L)): the transforms of the two spectra.
  for (const double r : {0.0, 10.0, 50.0, 100.0, 200.0, 400.0}) {
    const double decay = std::exp(-r / 100.0);
    const Eigen::Matrix3d expected = Vector3d(decay, decay * (1 - r / 200.0), decay * (1 - r / 200.0)).asDiagonal();
    INFO("r = " << r);
    CHECK((covariance(unit, Vector3d(r, 0, 0)) - expected).cwiseAbs().maxCoeff() < five_standard_errors);
  }
  // Isotropic: along z it is w that is longitudinal.
  const double decay = std::exp(-1.0);
  CHECK((covariance(unit, Vector3d(0, 0, 100.0)) - Eigen::Matrix3d(Vector3d(decay / 2, decay / 2, decay).asDiagonal()))
            .cwiseAbs()
            .maxCoeff() < five_standard_errors);
}

TEST_CASE("near the ground each component keeps its own length and intensity along the wind", "[dragcore][turbulence][analytic]") {
  Dryden parameters = low_altitude_dryden(30.48, 10.0);
  parameters.waves = 48;
  parameters.mean_wind = {0.0, 8.0, 0.0};  // u along y, v along -x
  const Vector3d sigma = parameters.intensity, length = parameters.length;
  const double r = 20.0;
  const Eigen::Matrix3d found = covariance(parameters, Vector3d(0, r, 0));
  CHECK_THAT(found(1, 1) / std::pow(sigma[0], 2), WithinAbs(std::exp(-r / length[0]), five_standard_errors));
  CHECK_THAT(found(0, 0) / std::pow(sigma[1], 2), WithinAbs(std::exp(-r / length[1]) * (1 - r / (2 * length[1])), five_standard_errors));
  CHECK_THAT(found(2, 2) / std::pow(sigma[2], 2), WithinAbs(std::exp(-r / length[2]) * (1 - r / (2 * length[2])), five_standard_errors));
}

TEST_CASE("the spectrum of a record at a fixed point is Dryden's, band by band", "[dragcore][turbulence][analytic]") {
  // A record of 64 L passes at 10 m/s; powers of its Fourier lines, Hann-windowed against leakage, summed over bands of a factor of two and
  // averaged over 150 seeds. Lines in a band: 5 to 40, two values each: the standard error of the ratio is sqrt(1.9 / (150 * lines)), below
  // 0.05; the tolerance is four of these, plus 0.02 for what the window smears over a band's slope.
  constexpr int points = 2048, seeds = 150;
  const double length = 100.0, speed = 10.0, record = 64 * length, step = record / points;
  std::array<Eigen::Array3d, 4> power{};
  const std::array<int, 5> edges{5, 10, 20, 40, 80};
  for (auto& band : power) band.setZero();
  for (int s = 0; s < seeds; ++s) {
    Dryden parameters = unit;
    parameters.seed = static_cast<std::uint64_t>(1000 + s);
    parameters.waves = 96;
    const Turbulence turbulence(parameters);
    Eigen::Matrix3Xd values(3, points);
    for (int i = 0; i < points; ++i)
      values.col(i) = turbulence.velocity(Vector3d::Zero(), i * step / speed) * std::sin(pi * i / points) * std::sin(pi * i / points);
    for (std::size_t band = 0; band < 4; ++band)
      for (int line = edges[band]; line < edges[band + 1]; ++line) {
        Eigen::Array3d re = Eigen::Array3d::Zero(), im = Eigen::Array3d::Zero();
        for (int i = 0; i < points; ++i) {
          const double phase = 2 * pi * ((static_cast<long>(line) * i) % points) / points;
          re += values.col(i).array() * std::cos(phase);
          im += values.col(i).array() * std::sin(phase);
        }
        power[band] += (re.square() + im.square()) * 2.0 / (0.375 * points) / points / seeds;  // 3/8: mean square of the window
      }
  }
  for (std::size_t band = 0; band < 4; ++band) {
    const double line = 2 * pi / record, low = (edges[band] - 0.5) * line, high = (edges[band + 1] - 0.5) * line;
    const auto in_band = [&](auto spectrum) {
      const auto of = [&](double w) { return spectrum(1.0, length, w); };
      return integral(of, length, high) - integral(of, length, low);
    };
    const double tolerance = 0.02 + 4 * std::sqrt(1.9 / (seeds * (edges[band + 1] - edges[band])));
    INFO("band " << band);
    CHECK_THAT(power[band][0] / in_band(dryden_longitudinal_spectrum), WithinAbs(1.0, tolerance));
    CHECK_THAT(power[band][1] / in_band(dryden_transverse_spectrum), WithinAbs(1.0, tolerance));
    CHECK_THAT(power[band][2] / in_band(dryden_transverse_spectrum), WithinAbs(1.0, tolerance));
  }
}

TEST_CASE("over a long time every seed has the variance asked for", "[dragcore][turbulence][analytic]") {
  // One seed, 20,000 instants over 2,000 eddies: the waves' beats leave a relative standard error of about sqrt(2 L / record) = 0.03.
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Turbulence turbulence(
        {.seed = seed, .intensity = {2.0, 1.0, 0.5}, .length = Vector3d::Constant(50.0), .mean_wind = {10.0, 0.0, 0.0}});
    Eigen::Array3d squares = Eigen::Array3d::Zero(), mean = Eigen::Array3d::Zero();
    for (int i = 0; i < 20'000; ++i) {
      const Vector3d v = turbulence.velocity(Vector3d::Zero(), i * 0.5);
      squares += v.array().square() / 20'000;
      mean += v.array() / 20'000;
    }
    for (int a = 0; a < 3; ++a) {
      CHECK_THAT(std::sqrt(squares[a]) / turbulence.parameters().intensity[a], WithinAbs(1.0, 0.1));
      CHECK_THAT(mean[a] / turbulence.parameters().intensity[a], WithinAbs(0.0, 0.15));
    }
  }
}

TEST_CASE("turbulence is a pure function of seed, place and time, carried by the mean wind", "[dragcore][turbulence][invariance]") {
  const Dryden parameters{.seed = 42, .mean_wind = {6.0, 2.0, 0.0}};
  const Turbulence a(parameters), b(parameters);
  const Vector3d here(12.0, -3.0, 4.0);
  const Vector3d late = a.velocity(here, 77.7);
  CHECK(a.velocity(here, -5.0) == b.velocity(here, -5.0));
  CHECK(b.velocity(here, 77.7) == late);
  CHECK(a.sample(here, 77.7).velocity == late);
  // Frozen: the air at (x, t) is that of (x - U t, 0); rounding of the phase, 700 m / 533 m * the highest wavenumber 220.
  CHECK((a.velocity(here - parameters.mean_wind * 77.7, 0.0) - late).norm() < 1e-10);
  Dryden other = parameters;
  other.seed = 43;
  CHECK((Turbulence(other).velocity(here, 77.7) - late).norm() > 1e-3);
  // The random sequence is pinned, so that replays survive a change of compiler; 1e-12 leaves room for another libm.
  CHECK((Turbulence({.seed = 1}).velocity(Vector3d(1.0, 2.0, 3.0), 4.0) -
         Vector3d(-0.22042350237444847, -0.27794060043296986, 1.1508752501878678))
            .norm() < 1e-12);
}

TEST_CASE("the gradient of turbulence is its derivative, and isotropic turbulence is free of divergence",
          "[dragcore][turbulence][analytic]") {
  const Turbulence turbulence(
      {.seed = 5, .intensity = {1.0, 1.0, 1.0}, .length = Vector3d::Constant(20.0), .mean_wind = {5.0, 3.0, 1.0}, .waves = 60});
  const Turbulence low([] {
    Dryden p = low_altitude_dryden(20.0, 12.0);
    p.mean_wind = {3.0, -4.0, 0.0};
    p.waves = 60;
    return p;
  }());
  for (const double t : {0.0, 3.3, 100.0}) {
    const Vector3d here(1.0 + t, 2.0, 3.0);
    for (const Turbulence* field : {&turbulence, &low}) {
      const WindSample sample = field->sample(here, t);
      // Central differences: error h^2/6 times the third derivative, about (70/20 m)^3.
      const double h = 1e-4;
      for (int a = 0; a < 3; ++a) {
        const Vector3d d = h * Vector3d::Unit(a);
        CHECK((sample.gradient.col(a) - (field->velocity(here + d, t) - field->velocity(here - d, t)) / (2 * h)).norm() < 1e-6);
      }
    }
    CHECK_THAT(turbulence.sample(here, t).gradient.trace(), WithinAbs(0.0, 1e-13));
  }
}

TEST_CASE("the stated variation of turbulence is four standard deviations of what is found", "[dragcore][turbulence][analytic]") {
  // 300 seeds, several directions: rms within 10 %.
  const Vector3d here(3.0, -2.0, 5.0);
  for (const double radius : {0.5, 5.0, 60.0}) {
    double constant = 0.0, affine = 0.0, stated_constant = 0.0, stated_affine = 0.0;
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    constexpr int seeds = 300, directions = 10;
    for (int s = 0; s < seeds; ++s) {
      Dryden parameters = unit;
      parameters.seed = static_cast<std::uint64_t>(s);
      const Turbulence turbulence(parameters);
      const WindSample centre = turbulence.sample(here, 1.0);
      for (int i = 0; i < directions; ++i) {
        const Vector3d d = radius * Vector3d(normal(random), normal(random), normal(random)).normalized();
        const Vector3d change = turbulence.velocity(here + d, 1.0) - centre.velocity;
        constant += change.squaredNorm() / (seeds * directions);
        affine += (change - centre.gradient * d).squaredNorm() / (seeds * directions);
      }
      stated_constant += std::pow(turbulence.variation(radius).constant / 4.0, 2) / seeds;
      stated_affine += std::pow(turbulence.variation(radius).affine / 4.0, 2) / seeds;
    }
    INFO("radius " << radius);
    CHECK_THAT(std::sqrt(stated_constant / constant), WithinAbs(1.0, 0.1));
    CHECK_THAT(std::sqrt(stated_affine / affine), WithinAbs(1.0, 0.1));
  }
}

TEST_CASE("turbulence stays finite at 1e9 s, in a vertical wind, in no wind and without intensity", "[dragcore][turbulence][hard]") {
  for (const Vector3d& wind : {Vector3d(0, 0, 7), Vector3d(0, 0, -7), Vector3d(0, 0, 0), Vector3d(1e-300, 0, 0), Vector3d(1e-7, 0, 7)}) {
    const Turbulence turbulence({.seed = 9, .mean_wind = wind});
    for (const double t : {-1e9, 0.0, 1e9}) {
      const WindSample sample = turbulence.sample(Vector3d(1e4, -1e4, 10.0), t);
      CHECK(sample.gradient.allFinite());
      // 192 waves of amplitude sqrt(6/192) cannot reach further than sqrt(6 * 192).
      CHECK(sample.velocity.norm() <= std::sqrt(6.0 * 192.0) + 1e-9);
    }
  }
  CHECK(Turbulence({.intensity = {0.0, 0.0, 0.0}}).velocity(Vector3d(1, 2, 3), 4.0) == Vector3d::Zero());
  CHECK_THROWS_WITH(Turbulence({.intensity = {1.0, -1.0, 1.0}}), Contains("intensity"));
  CHECK_THROWS_WITH(Turbulence({.length = {1.0, 0.0, 1.0}}), Contains("length"));
  CHECK_THROWS_WITH(Turbulence({.mean_wind = {std::nan(""), 0.0, 1.0}}), Contains("mean wind"));
  for (const int waves : {0, -3, 4, 2'000'000'000}) CHECK_THROWS_WITH(Turbulence({.waves = waves}), Contains("waves"));
}
