#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/gust.hpp>
#include <limits>
#include <numbers>

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using std::numbers::pi;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Midpoint rule; 200,000 points bring the error below 1e-9 for p >= 0.5.
double mean(GustProfile profile, double p) {
  double sum = 0.0;
  constexpr int points = 200'000;
  for (int i = 0; i < points; ++i) sum += gust_profile(profile, (i + 0.5) / points, p);
  return sum / points;
}

struct Extremes {
  double x_min = 0, min = 0, x_max = 0, max = 0;
};

Extremes extremes(GustProfile profile, double p) {
  Extremes found;
  constexpr int points = 100'000;
  for (int i = 0; i <= points; ++i) {
    const double x = double(i) / points, f = gust_profile(profile, x, p);
    if (f < found.min) found.x_min = x, found.min = f;
    if (f > found.max) found.x_max = x, found.max = f;
  }
  return found;
}

}  // namespace

TEST_CASE("the note's gust has a lull before its peak, as deep as its exponent says", "[dragcore][gust][analytic]") {
  // Extremes of -sin(2 pi x^p) sin(pi x / 2) from its derivative, three digits: 6e-4 is one unit of the last and the grid's spacing.
  struct Row {
    double p, x_min, min, x_max, max;
  };
  for (const Row& row : {Row{0.25, .028, -.024, .490, .595}, Row{0.5, .132, -.156, .626, .805}, Row{1, .318, -.436, .765, .929},
                         Row{2, .532, -.726, .869, .978}, Row{4, .716, -.899, .931, .994}}) {
    INFO("p = " << row.p);
    const Extremes found = extremes(GustProfile::note, row.p);
    CHECK_THAT(found.x_min, WithinAbs(row.x_min, 6e-4));
    CHECK_THAT(found.min, WithinAbs(row.min, 6e-4));
    CHECK_THAT(found.x_max, WithinAbs(row.x_max, 6e-4));
    CHECK_THAT(found.max, WithinAbs(row.max, 6e-4));
    // The lull turns into the gust where x^p = 1/2; rounding of the power times the slope.
    CHECK_THAT(gust_profile(GustProfile::note, std::pow(2.0, -1.0 / row.p), row.p), WithinAbs(0.0, 1e-14));
  }
}

TEST_CASE("the note's gust ends at zero but not smoothly, the smooth-ended one does", "[dragcore][gust][errata]") {
  for (const double p : {0.3, 1.0, 2.5}) {
    const double h = 1e-6;
    // One-sided difference: error h times the second derivative, about 100.
    CHECK_THAT((0.0 - gust_profile(GustProfile::note, 1.0 - h, p)) / h, WithinAbs(-2.0 * pi * p, 1e-4 * (1 + p * p)));
    CHECK_THAT((0.0 - gust_profile(GustProfile::smooth_ended, 1.0 - h, p)) / h, WithinAbs(0.0, 1e-4 * (1 + p * p)));
    for (const GustProfile profile : {GustProfile::note, GustProfile::smooth_ended, GustProfile::one_minus_cosine})
      for (const double end : {0.0, 1.0, -1e9, 1e9, -infinity, infinity}) CHECK(gust_profile(profile, end, p) == 0.0);
  }
  // Smooth-ended: p = 1 is antisymmetric with extremes 0.770, p = 2 has its minimum -1 at x... both from the derivative, three digits.
  const Extremes one = extremes(GustProfile::smooth_ended, 1.0), half = extremes(GustProfile::smooth_ended, 0.5);
  CHECK_THAT(one.max, WithinAbs(0.770, 6e-4));
  CHECK_THAT(one.min, WithinAbs(-one.max, 1e-9));
  CHECK_THAT(half.max, WithinAbs(0.988, 6e-4));
  CHECK_THAT(half.min, WithinAbs(-0.305, 6e-4));
}

TEST_CASE("on average the note's gust blows forward only for exponents below 1.68", "[dragcore][gust][errata]") {
  CHECK_THAT(mean(GustProfile::note, 0.5), WithinAbs(0.348, 6e-4));
  CHECK_THAT(mean(GustProfile::note, 1.0), WithinAbs(0.170, 6e-4));
  CHECK(mean(GustProfile::note, 1.679) > 0.0);
  CHECK(mean(GustProfile::note, 1.681) < 0.0);
}

TEST_CASE("the 1-cos gust rises to its amplitude and back, half of it on average", "[dragcore][gust][analytic]") {
  CHECK(gust_profile(GustProfile::one_minus_cosine, 0.5) == 1.0);
  CHECK_THAT(gust_profile(GustProfile::one_minus_cosine, 0.25), WithinAbs(0.5, 1e-15));
  CHECK_THAT(mean(GustProfile::one_minus_cosine, 1.0), WithinAbs(0.5, 1e-9));
  for (const double x : {0.1, 0.3, 0.49})
    CHECK_THAT(gust_profile(GustProfile::one_minus_cosine, 1.0 - x), WithinAbs(gust_profile(GustProfile::one_minus_cosine, x), 1e-15));
}

TEST_CASE("a gust is bounded by its amplitude for every exponent, from 1e-300 to 1e300", "[dragcore][gust][hard]") {
  for (const GustProfile profile : {GustProfile::note, GustProfile::smooth_ended})
    for (const double p : {5e-324, 1e-300, 1e-12, 1e-3, 1.0, 50.0, 1e6, 1e300})
      for (const double x : {5e-324, 1e-300, 1e-9, 0.1, 0.5, 0.999, std::nextafter(1.0, 0.0)}) {
        const double f = gust_profile(profile, x, p);
        CHECK(std::isfinite(f));
        CHECK(std::abs(f) <= 1.0);
      }
  // p -> 0: f -> -2 pi p ln(x) sin(pi x / 2), relative error p |ln x|: no cancellation however small p is.
  for (const double p : {1e-6, 1e-12, 1e-200}) {
    const double limit = -2.0 * pi * p * std::log(0.3) * std::sin(0.15 * pi);
    CHECK_THAT(gust_profile(GustProfile::note, 0.3, p) / limit, WithinAbs(1.0, 2.0 * p + 1e-14));
  }
  // p -> infinity: nothing before the very end.
  CHECK(gust_profile(GustProfile::note, 0.999, 1e6) == 0.0);
  for (const double p : {0.0, -1.0, not_a_number, infinity})
    CHECK_THROWS_WITH(gust_profile(GustProfile::note, 0.5, p), Catch::Contains("exponent") && Catch::Contains("greater than 0"));
  CHECK_THROWS_AS(gust_profile(GustProfile::note, not_a_number), std::invalid_argument);
}

TEST_CASE("a gust multiplies the wind only while it lasts", "[dragcore][gust][limit]") {
  const Gust gust{.start = 10.0, .duration = 4.0, .amplitude = 2.0, .rest = 1.0};
  for (const double t : {-1e9, 0.0, 10.0, 14.0, 1e9}) CHECK(gust_factor(gust, t) == 1.0);
  CHECK(gust_factor(gust, 13.0) == 1.0 + 2.0 * gust_profile(GustProfile::note, 0.75));
  CHECK(gust_factor(gust, 13.0) > 2.5);
  CHECK_THROWS_WITH(gust_factor(Gust{.duration = 0.0}, 1.0), Catch::Contains("duration"));
  CHECK_THROWS_WITH(gust_factor(Gust{.amplitude = not_a_number}, 1.0), Catch::Contains("amplitude"));
  CHECK_THROWS_AS(gust_factor(gust, not_a_number), std::invalid_argument);
}
