#include <algorithm>
#include <cmath>
#include <dragcore/gust.hpp>
#include <numbers>
#include <string>

#include "support/require.hpp"
#include "wind/batch_kernels.hpp"

namespace dragcore {

using std::numbers::pi;

namespace {

/// sin(2 pi x^p). Near x = 1 and for small p the power is close to 1, where its distance from 1 is what counts: expm1 keeps it, and makes
/// the end exactly 0.
double sine_of_power(double x, double p) {
  if (x == 0.0) return 0.0;
  const double exponent = p * std::log(x);
  return exponent > -0.5 ? std::sin(2.0 * pi * std::expm1(exponent)) : std::sin(2.0 * pi * std::exp(exponent));
}

}  // namespace

double gust_profile(GustProfile profile, double x, double p) {
  require(p > 0.0 && std::isfinite(p), "gust: exponent", p, "it must be greater than 0 and finite");
  require(!std::isnan(x), "gust: x", x, "it must be a number");
  if (x <= 0.0 || x >= 1.0) return 0.0;
  switch (profile) {
    case GustProfile::note:
      return -sine_of_power(x, p) * std::sin(0.5 * pi * x);
    case GustProfile::smooth_ended:
      return -sine_of_power(x, p) * std::sin(pi * std::min(x, 1.0 - x));  // sin(pi x) by its mirror image: exact near 1
    case GustProfile::one_minus_cosine: {
      const double half = std::sin(pi * x);
      return half * half;
    }
  }
  return 0.0;
}

void validate(const Gust& gust) {
  require_finite("gust: start", gust.start);
  require(gust.duration > 0.0 && std::isfinite(gust.duration), "gust: duration", gust.duration, "it must be greater than 0 s and finite");
  require_finite("gust: amplitude", gust.amplitude);
  require_finite("gust: rest", gust.rest);
  require(gust.exponent > 0.0 && std::isfinite(gust.exponent), "gust: exponent", gust.exponent, "it must be greater than 0 and finite");
}

double gust_factor(const Gust& gust, double time) {
  validate(gust);
  return gust.rest + gust.amplitude * gust_profile(gust.profile, (time - gust.start) / gust.duration, gust.exponent);
}

void gust_factors(const Gust& gust, std::span<const double> times, std::span<double> factors) {
  validate(gust);
  require(factors.size() == times.size(), "gust: number of factors", factors.size(),
          [&] { return "there are " + std::to_string(times.size()) + " times"; });
  for (std::size_t i = 0; i < times.size(); ++i)
    require(
        !std::isnan(times[i]), [&] { return "gust: time " + std::to_string(i); }, times[i], "it must be a number");
  if (gust_factors_by_kernel(gust, times, factors)) return;
  for (std::size_t i = 0; i < times.size(); ++i)
    factors[i] = gust.rest + gust.amplitude * gust_profile(gust.profile, (times[i] - gust.start) / gust.duration, gust.exponent);
}

}  // namespace dragcore
