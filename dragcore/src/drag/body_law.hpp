#pragma once

#include <algorithm>
#include <cmath>
#include <dragcore/descriptors.hpp>

#include "drag/relative_flow.hpp"

namespace dragcore {

/// A function of c and its derivative.
struct Curve {
  double value = 0.0, slope = 0.0;
  Curve operator*(const Curve& other) const { return {value * other.value, slope * other.value + value * other.slope}; }
  Curve operator*(double factor) const { return {value * factor, slope * factor}; }
};

/// c (1 + e)/(c + e): 0 at 0, 1 at 1, most of its rise below c = e.
inline Curve saturating(double c, double e) { return {c * (1.0 + e) / (c + e), (1.0 + e) * e / ((c + e) * (c + e))}; }

/// The law as one part sees it in one flow: descriptors worked in. Eq. 7 to 12.
class BodyLaw {
 public:
  /// @param directed  as RelativeFlow has it of the part
  /// @param layer     a/sqrt(Re_l) at 1 m/s: layer_scale()
  BodyLaw(const Law& law, const Descriptors& body, double directed, const ActiveEffects& active, double layer = 0.0)
      : law_(law), active_(active), layer_(layer) {
    const bool aspect = active.has<Effect::base_suction>() && law.aspect_gain != 0.0;
    if (aspect)
      aspect_factor_ +=
          directed * law.aspect_gain * body.aspect * body.aspect / (body.aspect * body.aspect + law.aspect_scale * law.aspect_scale);
    if (active.has<Effect::recovery>()) {
      instrument::count(Effect::recovery);
      // Suction that no wind made does not recover: a body in the lee of another must not be blown upwind.
      push_ = directed * body.reached * law.base_suction * law.recovery * body.depth / (body.depth + law.recovery_depth);
    }
    if (active.has<Effect::shelter>()) {
      instrument::count(Effect::shelter);
      sharpness_ = body.sharpness;
      const double square = body.sharpness * body.sharpness;
      shelter_ = directed * law.shelter * square * square;
    }
  }

  static bool needs_descriptors(const Law& law, const ActiveEffects& active) {
    return (active.has<Effect::base_suction>() && law.aspect_gain != 0.0) || active.has<Effect::recovery>() ||
           active.has<Effect::shelter>();
  }

  /// Visits (term, coefficient and slope) of everything that windward surface feels along its inward normal. `chi` is called only where it
  /// counts.
  template <class Chi, class Visit>
  void windward(double c, Chi&& chi, Visit&& visit) const {
    Curve shelter{1.0, 0.0};
    if (active_.has<Effect::shelter>() && sharpness_ > 0.0) {
      instrument::count(Effect::shelter);
      // p(x) = x^2/(x + 0.1) for x > 0: a smooth start of the ramp.
      if (const double x = 1.0 - c / sharpness_; x > 0.0) {
        const double ramp = x * x / (x + 0.1), ramp_slope = (x * x + 0.2 * x) / ((x + 0.1) * (x + 0.1));
        const double value = std::exp(-shelter_ * ramp);
        shelter = {value, value * shelter_ * ramp_slope / sharpness_};
      }
    }
    visit(Term::windward_pressure, shelter * Curve{evaluate(law_.windward, c), derivative(law_.windward, c)});
    if (active_.has<Effect::base_suction>()) {
      instrument::count(Effect::base_suction);
      visit(Term::base_suction, shelter * (saturating(c, law_.base_edge) * Curve{2.0 - c, -1.0}) * (law_.base_suction * aspect_factor_));
    }
    if (active_.has<Effect::curvature>()) {
      instrument::count(Effect::curvature);
      if (const double factor = chi(); factor > 0.0)
        visit(Term::curvature, shelter * (saturating(c, 0.2) * Curve{1.0 - c * c, -2.0 * c}) * (-law_.curvature * factor));
    }
  }

  /// The same along the outward normal of leeward surface.
  template <class Visit>
  void leeward(double c, Visit&& visit) const {
    if (active_.has<Effect::leeward_suction>()) {
      instrument::count(Effect::leeward_suction);
      visit(Term::leeward_suction, Curve{evaluate(law_.leeward, c), derivative(law_.leeward, c)});
    }
    if (active_.has<Effect::recovery>() && push_ > 0.0) {
      instrument::count(Effect::recovery);
      visit(Term::rear_recovery, saturating(c, law_.recovery_edge) * -push_);
    }
  }

  /// Friction of the boundary layer on the side of a normal, eq. 16, in a flow of 1 m/s; it goes with the root of the Reynolds number.
  /// @param s    -u.n/|u|; the derivative is by it
  /// @param chi  how much that side curves along the flow
  Curve layer(double s, double chi) const {
    const double steep = 1.0 / std::sqrt(1.0 + 2.25 * s * s), here = layer_ * (1.0 + law_.layer_curvature * chi);
    return {here * (1.0 + 1.5 * s * steep), here * 1.5 * steep * steep * steep};
  }

  // What the flow and the body made of the law's numbers.
  double base_suction() const { return active_.has<Effect::base_suction>() ? law_.base_suction * aspect_factor_ : 0.0; }
  double shelter_rate() const { return sharpness_ > 0.0 ? shelter_ : 0.0; }
  double sharpness() const { return sharpness_; }
  double push() const { return push_; }
  const Law& law() const { return law_; }
  double layer_scale() const { return active_.has<Effect::viscous>() ? layer_ : 0.0; }
  double friction() const { return active_.has<Effect::friction>() ? law_.friction : 0.0; }
  bool feels_leeward() const { return active_.has<Effect::leeward_suction>() || (active_.has<Effect::recovery>() && push_ > 0.0); }

 private:
  const Law& law_;
  ActiveEffects active_;
  double layer_ = 0.0, aspect_factor_ = 1.0, push_ = 0.0, shelter_ = 0.0, sharpness_ = 0.0;
};

}  // namespace dragcore
