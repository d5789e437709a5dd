#pragma once

#include <array>
#include <string>

namespace dragcore {

/// A pressure law is data: what a piece of surface feels as a polynomial of c = |w|/|u|, the cosine between its normal and the flow.
///
///   windward (w > 0):  pressure  q (W0 + W1 c + W2 c^2 + W3 c^3 + W4 c^4), pushes along -n
///   leeward  (w < 0):  suction   q (L0 + L1 c + ...), pulls along +n;      q = rho |u|^2 / 2
///
/// A two-sided sheet has one of each on its two sides. W0 and L0 should be 0: otherwise the force jumps as a face turns edge-on.
/// Non-negative values on [0, 1] make the law passive: in still air it never adds energy to a body.
struct Law {
  using Polynomial = std::array<double, 5>;
  std::string name{};
  Polynomial windward{};
  Polynomial leeward{};
};

/// The note's law, C_N = c^2 (2 - c): the air loses the normal part of its velocity, force along -n. [toskan2020] sec. 2.
Law note_law();

/// The same balance with the work done along the flow, C_N = c (2 - c): docs/model.md, erratum E2.
Law consistent_law();

/// k_w times the note's windward law, and base suction k_b c (2 - c) on leeward faces: the two coefficients that `dragval calibrate` fits.
Law scaled_law(double windward_scale, double base_suction);

/// "note" or "consistent". @throws std::invalid_argument with the known names
Law named_law(const std::string& name);

/// p(c) by Horner's rule.
double evaluate(const Law::Polynomial& polynomial, double c);

}  // namespace dragcore
