#pragma once

#include <Eigen/Core>
#include <compare/case_record/case_record.hpp>
#include <string>
#include <vector>

#include "cfd_cases/flow_case/matrix.hpp"

namespace cfd_cases {

/// Six channels of one iteration as coefficients: C_D, C_S, C_L, C_l, C_m, C_n.
using Channels = case_record::CaseRecord::Channels;

/// Standard error of the mean of a correlated series: s sqrt(2 tau / n), with the integrated autocorrelation time tau summed up to five tau
/// (Sokal's window). A constant series has 0.
double standard_error(const Eigen::VectorXd& series);

/// What the forces say about a run.
struct Verdict {
  case_record::Status status = case_record::Status::drifting;
  std::string reason;     ///< empty when usable
  bool stop = false;      ///< no reason to go on
  int averaged_over = 0;  ///< last iterations, of which to take the mean
  Channels u_iteration = Channels::Zero();
  Channels u_statistical = Channels::Zero();
};

/// Judges a series of channels, one per iteration. Residuals are not asked: they level off and say nothing.
///
/// * steady: over the last `window` iterations every channel keeps within `tolerance` of max(|C_D|, floor), from its smallest to its
/// largest value
///   and by the slope of its trend. The mean of the last `average` is the result; u_iteration is half the spread over the window.
/// * statistically_steady, tried from 3 windows on: over the later half of the run the means of its halves differ by less than twice the
///   standard error of that difference plus the tolerance, and the standard error of the mean is below `mean_error` of max(|C_D|, floor).
///   u_statistical is that standard error, u_iteration half the difference of the halves. For a run to end on it, it takes 5 windows.
/// * diverged: a channel is not finite, or beyond `plausible` (after `window` iterations also beyond 100 times that: stop at once), or
///   C_D <= 0 when the run is judged at its end.
/// * drifting: none of these; the reason names the channel that moves most.
///
/// @param plausible  largest believable size of a coefficient
/// @param ended      the run is over: judge what there is
/// @param still_air  the body spins without wind: its moment takes the place of C_D, and the moments alone decide
Verdict judge(const std::vector<Channels>& series, const StopPolicy& policy, double plausible, bool ended, bool still_air = false);

/// Judges a time-accurate run, one set of channels per time step. It ends when its time is over; the mean of what comes after `discard`
/// steps is the result, statistically_steady. u_statistical is the larger of its standard error and half the difference of the means of its
/// halves, which knows of slow drifts. diverged: as above.
Verdict judge_in_time(const std::vector<Channels>& series, std::size_t discard, double plausible, bool ended);

}  // namespace cfd_cases
