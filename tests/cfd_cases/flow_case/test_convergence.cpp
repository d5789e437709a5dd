#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "cfd_cases/flow_case/convergence.hpp"

using namespace cfd_cases;
using case_record::Status;
using Catch::Matchers::Contains;

namespace {

constexpr double kPlausible = 8.0;
const StopPolicy kPolicy;

/// n iterations with C_D = drag(i); the other channels are 0.
std::vector<Channels> series(int n, const std::function<double(int)>& drag) {
  std::vector<Channels> all(static_cast<std::size_t>(n), Channels::Zero());
  for (int i = 0; i < n; ++i) all[static_cast<std::size_t>(i)][0] = drag(i);
  return all;
}

}  // namespace

TEST_CASE("forces that stand still are steady without uncertainty as soon as the minimum is reached",
          "[cfd_cases][convergence][analytic]") {
  const auto still = [](int) { return 1.05; };
  CHECK_FALSE(judge(series(kPolicy.min_iterations - 1, still), kPolicy, kPlausible, false).stop);
  const Verdict verdict = judge(series(kPolicy.min_iterations, still), kPolicy, kPlausible, false);
  CHECK(verdict.stop);
  CHECK(verdict.status == Status::steady);
  CHECK(verdict.averaged_over == kPolicy.average);
  CHECK(verdict.u_iteration.maxCoeff() == 0.0);
}

TEST_CASE("a drift below the tolerance is steady with half its size as uncertainty, above it the run goes on",
          "[cfd_cases][convergence][limit]") {
  // Over a window of 100 iterations a line of slope s spreads by 99 s.
  const auto drifting = [](double per_window) { return series(200, [=](int i) { return 1.0 + per_window * i / 99.0; }); };
  const Verdict slow = judge(drifting(0.0029), kPolicy, kPlausible, false);
  CHECK(slow.status == Status::steady);
  CHECK(slow.u_iteration[0] == Approx(0.5 * 0.0029));
  CHECK_FALSE(judge(drifting(0.0032), kPolicy, kPlausible, false).stop);
  const Verdict ended = judge(drifting(0.0032), kPolicy, kPlausible, true);
  CHECK(ended.status == Status::drifting);
  CHECK_THAT(ended.reason, Contains("C_D") && Contains("max_iterations"));
}

TEST_CASE("every one of the six channels must stand still, on the scale of the drag", "[cfd_cases][convergence]") {
  for (int channel = 1; channel < 6; ++channel) {
    CAPTURE(channel);
    auto forces = series(200, [](int) { return 1.0; });
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i][channel] = 1e-4 * static_cast<double>(i);  // 1 % of C_D per window
    CHECK(judge(forces, kPolicy, kPlausible, true).status == Status::drifting);
  }
}

TEST_CASE("a body with hardly any drag is judged on the floor, not on its own drag", "[cfd_cases][convergence][limit]") {
  const auto forces = series(200, [](int i) { return 1e-3 + 1e-6 * i; });  // 10 % of C_D per window, but 0.1 % of the floor
  CHECK(judge(forces, kPolicy, kPlausible, false).status == Status::steady);
}

TEST_CASE("an oscillation about a mean is averaged, and its mean lies within the stated uncertainty",
          "[cfd_cases][convergence][analytic]") {
  const auto oscillating = series(500, [](int i) { return 1.0 + 0.02 * std::sin(2.0 * std::numbers::pi * i / 37.0); });
  const Verdict verdict = judge(oscillating, kPolicy, kPlausible, false);
  REQUIRE(verdict.status == Status::statistically_steady);
  CHECK(verdict.stop);
  double mean = 0.0;
  for (int i = 0; i < verdict.averaged_over; ++i)
    mean += oscillating[oscillating.size() - 1 - static_cast<std::size_t>(i)][0] / verdict.averaged_over;
  const double u = std::hypot(verdict.u_statistical[0], verdict.u_iteration[0]);
  CHECK(u > 0.0);
  CHECK(u < 0.01);  // of an amplitude of 0.02
  CHECK(std::abs(mean - 1.0) <= 2.0 * u);
}

TEST_CASE("an oscillation that also drifts is not called statistically steady", "[cfd_cases][convergence]") {
  const auto forces = series(500, [](int i) { return 1.0 + 0.001 * i + 0.02 * std::sin(2.0 * std::numbers::pi * i / 37.0); });
  CHECK(judge(forces, kPolicy, kPlausible, true).status == Status::drifting);
}

TEST_CASE("values that are not finite or not plausible are a divergence at once", "[cfd_cases][convergence][hard]") {
  const auto broken = series(20, [](int i) { return i == 19 ? std::numeric_limits<double>::quiet_NaN() : 1.0; });
  CHECK(judge(broken, kPolicy, kPlausible, false).status == Status::diverged);
  const auto huge = series(150, [](int i) { return i < 140 ? 1.0 : 1e3; });
  CHECK(judge(huge, kPolicy, kPlausible, false).status == Status::diverged);
  // The case that came back with return code 0 and a C_D of -2e4.
  CHECK(judge(series(300, [](int) { return -2e4; }), kPolicy, kPlausible, true).status == Status::diverged);
  CHECK(judge(series(300, [](int) { return -0.1; }), kPolicy, kPlausible, true).status == Status::diverged);
  CHECK(judge({}, kPolicy, kPlausible, true).status == Status::failed);
}

TEST_CASE("the jolt of an impulsive start is no divergence", "[cfd_cases][convergence][regression]") {
  // Seen on every shape: C_D of -200 within the first iterations of a case that converges.
  const auto forces = series(200, [](int i) { return i < 5 ? -200.0 : 1.0; });
  CHECK_FALSE(judge({forces.begin(), forces.begin() + 4}, kPolicy, kPlausible, false).stop);
  CHECK(judge(forces, kPolicy, kPlausible, false).status == Status::steady);
}

TEST_CASE("the standard error of correlated noise is that of theory", "[cfd_cases][convergence][analytic]") {
  // x_i = a x_{i-1} + noise has 2 tau = (1 + a) / (1 - a). 20,000 samples with a fixed seed: tau is known to about sqrt(2 (2M + 1) / n)
  // with a window M of 5 tau, that is 7 % for a = 0.8; its root to half of that. 15 % is four times the error.
  std::mt19937 generator(1);
  std::normal_distribution<double> noise;
  for (const double a : {0.0, 0.5, 0.8}) {
    CAPTURE(a);
    Eigen::VectorXd x(20000);
    double value = 0.0;
    for (double& sample : x) sample = value = a * value + noise(generator);
    const double expected = std::sqrt((1.0 + a) / (1.0 - a) / (1.0 - a * a) / 20000.0);
    CHECK(standard_error(x) == Approx(expected).epsilon(0.15));
  }
  CHECK(standard_error(Eigen::VectorXd::Constant(50, 3.0)) == 0.0);
}

TEST_CASE("a run in time is judged when it is over, by what comes after its start", "[cfd_cases][convergence][analytic]") {
  // A start at 3, then a wave of 50 steps about 1.2: four whole waves have exactly that mean.
  const auto wave = [](int i) { return i < 100 ? 3.0 : 1.2 + 0.1 * std::sin(2.0 * std::numbers::pi * i / 50.0); };
  CHECK_FALSE(judge_in_time(series(300, wave), 100, kPlausible, false).stop);
  const Verdict verdict = judge_in_time(series(300, wave), 100, kPlausible, true);
  CHECK(verdict.status == Status::statistically_steady);
  CHECK(verdict.averaged_over == 200);
  // The halves are equal; the autocorrelation of a wave, summed over a window, cancels but for a part of its first half wave.
  CHECK(verdict.u_statistical[0] < 0.02);
  // A drift shows as half the difference of the halves: 100 steps at 1e-3 each, halved.
  const Verdict drift = judge_in_time(series(300, [](int i) { return 1.0 + 1e-3 * i; }), 100, kPlausible, true);
  CHECK(drift.u_statistical[0] >= Approx(0.05));
  CHECK(judge_in_time(series(90, wave), 100, kPlausible, true).status == Status::drifting);
  CHECK(judge_in_time(series(300, [](int) { return NAN; }), 100, kPlausible, true).status == Status::diverged);
}

TEST_CASE("a body that spins in still air is judged by its moment", "[cfd_cases][convergence]") {
  const auto moment = [](double drift) {
    std::vector<Channels> all(200, Channels::Zero());
    for (std::size_t i = 0; i < all.size(); ++i) all[i][5] = -0.02 * (1.0 + drift * static_cast<double>(i));
    return all;
  };
  CHECK(judge(moment(0.0), kPolicy, kPlausible, false, true).status == Status::steady);
  CHECK(judge(moment(0.0), kPolicy, kPlausible, true, true).status == Status::steady);  // no drag is no divergence
  // 1e-4 per iteration is 1 % of the moment over the window, allowed is 0.3 %; against C_D's floor of 0.1 it would pass.
  CHECK_FALSE(judge(moment(1e-4), kPolicy, kPlausible, false, true).stop);
  // A restless wake pushes the body to and fro, and has no say.
  auto restless = moment(0.0);
  for (std::size_t i = 0; i < restless.size(); ++i) restless[i][1] = 0.3 * std::sin(0.05 * static_cast<double>(i));
  CHECK(judge(restless, kPolicy, kPlausible, false, true).status == Status::steady);
}

TEST_CASE("a wake that swings too far for a mean within 1 % is accepted where the policy asks for less", "[cfd_cases][convergence]") {
  // 7 % of noise that is remembered for some six iterations, as by a transition model; the seed is fixed.
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0.0, 0.07);
  double memory = 0.0;
  std::vector<double> drag;
  for (int i = 0; i < 500; ++i) drag.push_back(0.4 * (1.0 + (memory = 0.85 * memory + noise(random) * std::sqrt(1.0 - 0.85 * 0.85))));
  const auto swinging = series(500, [&](int i) { return drag[static_cast<std::size_t>(i)]; });
  CHECK(judge(swinging, kPolicy, kPlausible, true).status == Status::drifting);
  StopPolicy patient;
  patient.mean_error = 0.03;
  const Verdict verdict = judge(swinging, patient, kPlausible, false);
  CHECK(verdict.status == Status::statistically_steady);
  CHECK(verdict.stop);
  CHECK(verdict.averaged_over == 250);
  CHECK(verdict.u_statistical[0] > 0.01 * 0.4);  // and it says so
}
