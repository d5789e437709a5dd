#pragma once

#include <span>

namespace dragcore {

/// Shapes of a gust over x = elapsed / duration in [0, 1], zero outside.
enum class GustProfile {
  note,              ///< -sin(2 pi x^p) sin(pi x / 2): a lull, then the gust; ends at zero with slope -2 pi p
  smooth_ended,      ///< -sin(2 pi x^p) sin(pi x): the same, but with slope 0 at the end
  one_minus_cosine,  ///< (1 - cos(2 pi x)) / 2: the discrete gust of the airworthiness rules, no lull; p is not used
};

/// A gust as a factor on the intensity of a wind source: rest + amplitude * profile.
struct Gust {
  GustProfile profile = GustProfile::note;
  double start = 0.0;     ///< [s]
  double duration = 1.0;  ///< > 0 [s]
  double amplitude = 1.0;
  double rest = 1.0;      ///< outside the gust; 0 for a source that is the gust alone
  double exponent = 1.0;  ///< the note's p > 0: below 0.356 the lull is less than a tenth of the peak, 0.5 a fifth, 1 half
};

/// Value of the profile at x, clamped to [0, 1]. Exactly 0 at both ends, for every p.
/// @throws std::invalid_argument  if p is not positive and finite or x is not a number
/// @source [toskan2020] sec. 3.3; differs: x is defined and clamped, the printed t is x (erratum E27)
double gust_profile(GustProfile profile, double x, double p = 1.0);

/// @throws std::invalid_argument  on a duration or exponent that is not positive, or anything not finite
void validate(const Gust& gust);

/// The factor at `time` [s]: a pure function. @throws std::invalid_argument as validate
double gust_factor(const Gust& gust, double time);

/// The factors at many times [s], say of one gust that reaches many bodies one after the other. Each factor depends on its time alone.
/// @param factors  as many as times, may be the same memory
/// @throws std::invalid_argument  as validate; on a time that is not a number, or spans of different lengths: nothing is written then
/// @accuracy       gust_factor() to 1e-14 of the amplitude: 8 or 4 times at once where the library was built with kernels (DRAGCORE_SIMD)
void gust_factors(const Gust& gust, std::span<const double> times, std::span<double> factors);

}  // namespace dragcore
