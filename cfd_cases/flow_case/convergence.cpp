#include "cfd_cases/flow_case/convergence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace cfd_cases {

using case_record::Status;
using Series = Eigen::Matrix<double, 6, Eigen::Dynamic>;

namespace {

constexpr std::array<const char*, 6> kChannelNames{"C_D", "C_S", "C_L", "C_l", "C_m", "C_n"};

Series last(const std::vector<Channels>& series, Eigen::Index n) {
  Series block(6, n);
  for (Eigen::Index i = 0; i < n; ++i) block.col(i) = series[series.size() - static_cast<std::size_t>(n - i)];
  return block;
}

/// Change of the least-squares line over the block, per channel.
Channels trend(const Series& block) {
  const Eigen::RowVectorXd t = Eigen::RowVectorXd::LinSpaced(block.cols(), -0.5, 0.5);
  return block * t.transpose() / t.squaredNorm();
}

Verdict hopeless_case(Status status, std::string reason) { return {.status = status, .reason = std::move(reason), .stop = true}; }

/// What no further iteration mends: no forces at the end, or forces that nobody can believe.
std::optional<Verdict> give_up_early(const std::vector<Channels>& series, int start, double plausible, bool ended, bool still_air) {
  const auto n = static_cast<Eigen::Index>(series.size());
  if (n == 0) return ended ? std::optional(hopeless_case(Status::failed, "the solver wrote no forces")) : std::nullopt;
  const Channels& now = series.back();
  for (int c = 0; c < 6; ++c) {
    // The impulsive start throws forces a hundred times too large: only what lasts beyond it is a divergence.
    if (!std::isfinite(now[c]) || ((ended || n > start) && std::abs(now[c]) > (ended ? 1.0 : 100.0) * plausible))
      return hopeless_case(Status::diverged, fmt::format("{} = {:.4g} after {} iterations, plausible is up to {:.3g}",
                                                         kChannelNames[static_cast<std::size_t>(c)], now[c], n, plausible));
  }
  if (ended && !still_air && now[0] <= 0.0)
    return hopeless_case(Status::diverged,
                         fmt::format("C_D = {:.4g} after {} iterations, but the air cannot pull a body upwind", now[0], n));
  return std::nullopt;
}

}  // namespace

double standard_error(const Eigen::VectorXd& series) {
  const Eigen::Index n = series.size();
  if (n < 2) return 0.0;
  const Eigen::VectorXd x = series.array() - series.mean();
  const double variance = x.squaredNorm() / static_cast<double>(n);
  if (variance == 0.0) return 0.0;
  double tau = 0.5;
  for (Eigen::Index lag = 1; lag < n / 2 && static_cast<double>(lag) < 5.0 * tau + 1.0; ++lag)
    tau += x.head(n - lag).dot(x.tail(n - lag)) / (static_cast<double>(n) * variance);
  // An oscillation sums to almost nothing; never claim more than n independent samples.
  tau = std::max(tau, 0.5);
  return std::sqrt(variance * 2.0 * tau / static_cast<double>(n - 1));
}

Verdict judge(const std::vector<Channels>& series, const StopPolicy& policy, double plausible, bool ended, bool still_air) {
  if (auto hopeless = give_up_early(series, policy.window, plausible, ended, still_air)) return *hopeless;
  Verdict verdict;
  const auto n = static_cast<Eigen::Index>(series.size());
  if (n == 0 || (!ended && n < policy.min_iterations)) return verdict;

  const Eigen::Index window = std::min<Eigen::Index>(policy.window, n);
  const Series recent = last(series, window);
  const double scale = still_air ? recent.bottomRows<3>().rowwise().mean().norm() : std::max(std::abs(recent.row(0).mean()), policy.floor);
  const double allowed = policy.tolerance * scale;
  // In still air forces are what the symmetry of a turn leaves of a restless wake: the moment alone decides.
  Channels counts = Channels::Ones();
  if (still_air) counts.head<3>().setZero();
  const Channels spread = (recent.rowwise().maxCoeff() - recent.rowwise().minCoeff()).cwiseProduct(counts);
  const Channels drift = trend(recent).cwiseAbs().cwiseProduct(counts);
  if (n >= policy.min_iterations && spread.maxCoeff() <= allowed && drift.maxCoeff() <= allowed) {
    verdict.status = Status::steady;
    verdict.stop = true;
    verdict.averaged_over = policy.average;
    verdict.u_iteration = 0.5 * (recent.rowwise().maxCoeff() - recent.rowwise().minCoeff());
    return verdict;
  }

  if (n >= 3 * policy.window) {
    const Eigen::Index half = n / 4;
    const Series late = last(series, 2 * half);
    Channels difference = (late.rightCols(half).rowwise().mean() - late.leftCols(half).rowwise().mean()).cwiseAbs(), error;
    bool stationary = true;
    for (int c = 0; c < 6; ++c) {
      error[c] = standard_error(late.row(c).transpose());
      const double of_halves =
          std::hypot(standard_error(late.row(c).head(half).transpose()), standard_error(late.row(c).tail(half).transpose()));
      stationary = stationary && (counts[c] == 0.0 || difference[c] <= 2.0 * of_halves + allowed);
    }
    // 1 % of C_D is what the medium mesh itself is good for: averaging longer would buy nothing.
    if (stationary && error.cwiseProduct(counts).maxCoeff() <= policy.mean_error * scale) {
      verdict.status = Status::statistically_steady;
      verdict.stop = n >= 5 * policy.window;
      verdict.averaged_over = static_cast<int>(2 * half);
      verdict.u_statistical = error;
      verdict.u_iteration = 0.5 * difference;
      return verdict;
    }
  }
  if (ended) {
    Eigen::Index worst = 0;
    const double largest = spread.maxCoeff(&worst);
    return hopeless_case(
        Status::drifting,
        fmt::format(
            "{} still moves by {:.2g} within {} iterations after {} of them, allowed is {:.2g}: raise max_iterations, or use a finer mesh",
            kChannelNames[static_cast<std::size_t>(worst)], largest, window, n, allowed));
  }
  return verdict;
}

Verdict judge_in_time(const std::vector<Channels>& series, std::size_t discard, double plausible, bool ended) {
  if (auto hopeless = give_up_early(series, static_cast<int>(discard), plausible, ended, false)) return *hopeless;
  Verdict verdict;
  if (!ended) return verdict;
  if (series.size() < discard + 4)
    return hopeless_case(Status::drifting,
                         fmt::format("ended after {} steps, of which {} are no part of the mean", series.size(), discard));
  const auto n = static_cast<Eigen::Index>(series.size() - discard), half = n / 2;
  const Series kept = last(series, n);
  const Channels difference = (kept.rightCols(half).rowwise().mean() - kept.leftCols(half).rowwise().mean()).cwiseAbs();
  verdict.status = Status::statistically_steady;
  verdict.averaged_over = static_cast<int>(n);
  for (int c = 0; c < 6; ++c) verdict.u_statistical[c] = std::max(standard_error(kept.row(c).transpose()), 0.5 * difference[c]);
  return verdict;
}

}  // namespace cfd_cases
