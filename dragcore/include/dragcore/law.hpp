#pragma once

#include <array>
#include <dragcore/body_class.hpp>
#include <string>
#include <vector>

namespace dragcore {

/// A law is data: what a piece of surface feels, as a function of c = |w|/|u|, the cosine between its normal and the flow, and of a few
/// descriptors of the whole body seen along the flow (descriptors.hpp). q = rho |u|^2/2; docs/model.md, eq. 2, 3 and 7 to 12.
///
///   windward (w > 0):  pressure  q S (W(c) + B h g(c) - m chi l(c)),   pushes along -n
///   leeward  (w < 0):  suction   q (L(c) - B R lambda/(lambda + lambda_0) r(c)),   pulls along +n
///   everywhere:        friction  q f |t| along the tangential part of u, t = |u_t|/|u|
///
/// Where the viscosity is known (Medium), two terms of eq. 15 and 16 take the place of f, with Re_l = |u| l/nu, l = sqrt(wetted area/pi):
///
///   of the whole part: Stokes' resistance, sigma times that of the ellipsoid of equal second moments, linear in the velocity
///   everywhere:        friction  q a/sqrt(Re_l) (1 + h(s)) (1 + g chi) |t|,  s = -u.n/|u|,  h = 1.5 s/sqrt(1 + 2.25 s^2)
///
/// W and L are polynomials. Pressures count from that of a face parallel to the flow, which closed bodies cannot tell from any other gauge:
/// so every term vanishes at c = 0 and no force jumps as a face turns edge-on. B is then the suction behind a flat body as felt from the
/// front, R the share of it that an infinitely deep body recovers. A two-sided sheet has a windward and a leeward side at once. All numbers
/// zero but W: the note.
///
/// Terms that push a body through the air (negative values) never win: wrench() holds them below `largest_gain` of what the others take
/// (eq. 13).
struct Law {
  using Polynomial = std::array<double, 5>;
  std::string name{};
  Polynomial windward{};        ///< W: coefficients of 1, c, c^2, c^3, c^4
  Polynomial leeward{};         ///< L
  double friction = 0.0;        ///< f >= 0, per wetted side
  double base_suction = 0.0;    ///< B >= 0
  double base_edge = 0.3;       ///< epsilon > 0 of g(c) = c (1 + epsilon)/(c + epsilon) (2 - c)
  double aspect_gain = 0.0;     ///< of h = 1 + gain AR^2/(AR^2 + scale^2) >= 0, AR the aspect ratio of the silhouette
  double aspect_scale = 24.0;   ///< > 0
  double recovery = 0.0;        ///< R in [0, 1]
  double recovery_depth = 1.2;  ///< lambda_0 > 0, of lambda = volume / frontal area^1.5
  double recovery_edge = 0.3;   ///< e > 0 of r(c) = c (1 + e)/(c + e)
  double shelter = 0.0;         ///< s >= 0 of S = exp(-s M p(1 - c/k)), k the sharpness of the body's windward side, M = k^4
  double curvature = 0.0;       ///< m >= 0; chi says how much the surface curves along the flow, l(c) = (1 - c^2) 1.2 c/(c + 0.2)
  double stokes = 0.0;          ///< sigma >= 0; 1: exact for a ball as Re -> 0
  double layer = 0.0;           ///< a >= 0: friction of the boundary layer
  double layer_curvature = 0.0;  ///< g >= 0: how much it grows where the surface curves along the flow

  bool viscous() const { return stokes > 0.0 || layer > 0.0; }

  bool operator==(const Law&) const = default;
};

/// The note's law, C_N = c^2 (2 - c): the air loses the normal part of its velocity, force along -n. [toskan2020] sec. 2.
Law note_law();

/// The same balance with the work done along the flow, C_N = c (2 - c): docs/model.md, erratum E2.
Law consistent_law();

/// For thin plates and discs at Re >= 1e4, and below where the viscosity is known: dragcore/laws/sheet.toml says what it was fitted to.
Law sheet_law();

/// For closed bodies, likewise: dragcore/laws/closed.toml says what it was fitted to.
Law closed_law();

/// k_w times the note's windward law, and base suction k_b c (2 - c) on leeward faces: the two coefficients that `dragval calibrate` fits
/// to C_D alone.
Law scaled_law(double windward_scale, double base_suction);

/// The law that validation found best for a class: sheet_law() or closed_law(). See README for its errors.
Law law_for(BodyClass body_class);

/// Names that named_law() knows: "note", "consistent", "sheet", "closed".
const std::vector<std::string>& law_names();

/// @throws std::invalid_argument with the known names
Law named_law(const std::string& name);

/// @throws std::invalid_argument  if a number is not finite or out of the range stated above: which, found, needed
void validate(const Law& law);

/// p(c) by Horner's rule, and its derivative.
double evaluate(const Law::Polynomial& polynomial, double c);
double derivative(const Law::Polynomial& polynomial, double c);

}  // namespace dragcore
