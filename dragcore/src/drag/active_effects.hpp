#pragma once

#include <algorithm>
#include <dragcore/drag.hpp>

#include "drag/instrument.hpp"

namespace dragcore {

/// Which effects this evaluation has: allowed by the model, part of the law, the pillow and the motion, and built.
class ActiveEffects {
 public:
  ActiveEffects(const Motion& motion, const Model& model) : ActiveEffects(motion, model, model.law, model.pillow) {}

  /// With the law and the pillow of one part. In a medium whose viscosity is known, the viscous terms take the place of friction.
  ActiveEffects(const Motion& motion, const Model& model, const Law& law, const Pillow& pillow, const Medium& medium = {}) {
    const auto any = [](const Law::Polynomial& p) { return std::any_of(p.begin(), p.end(), [](double x) { return x != 0.0; }); };
    set(Effect::leeward_suction, any(law.leeward), model);
    set(Effect::viscous, medium.viscosity > 0.0 && law.viscous(), model);
    set(Effect::friction, law.friction != 0.0 && !has<Effect::viscous>(), model);
    set(Effect::base_suction, law.base_suction != 0.0, model);
    set(Effect::recovery, law.base_suction * law.recovery != 0.0, model);
    set(Effect::shelter, law.shelter != 0.0, model);
    set(Effect::curvature, law.curvature != 0.0, model);
    set(Effect::pillow, pillow.form != PillowForm::none && (pillow.factor > 0.0 || pillow.form == PillowForm::eccentricity), model);
    set(Effect::spin, !motion.angular_velocity.isZero(0.0), model);
    set(Effect::wind_variation, !motion.triangle_wind.empty() || !motion.wind_gradient.isZero(0.0), model);
  }

  template <Effect effect>
  bool has() const {
    if constexpr (!instrument::built(effect)) return false;
    return on_.has(effect);
  }

 private:
  void set(Effect effect, bool called_for, const Model& model) {
    if (called_for && model.effects.has(effect)) on_ = on_ | effect;
  }
  Effects on_;
};

}  // namespace dragcore
