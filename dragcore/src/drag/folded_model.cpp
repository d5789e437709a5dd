#include "drag/folded_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <stdexcept>

#include "drag/check.hpp"

namespace dragcore {

bool never_negative(const Law::Polynomial& p) {
  static constexpr double share[5][5] = {
      {1, 0, 0, 0, 0}, {1, 1.0 / 4, 0, 0, 0}, {1, 2.0 / 4, 1.0 / 6, 0, 0}, {1, 3.0 / 4, 3.0 / 6, 1.0 / 4, 0}, {1, 1, 1, 1, 1}};
  return std::none_of(std::begin(share), std::end(share), [&](const auto& row) {
    double sum = 0.0;
    for (std::size_t k = 0; k < p.size(); ++k) sum += row[k] * p[k];
    return sum < 0.0;
  });
}

namespace {

/// Whether a law's numbers are numbers in single precision, and products of three of its edges: what is checked may be beyond it, what is
/// not may be none.
bool fits(const Law& law) {
  const auto usable = [](double x) { return std::abs(x) < 1e30; };
  const auto divides = [](double x) { return x > 1e-10 && x < 1e10; };
  return std::all_of(law.windward.begin(), law.windward.end(), usable) && std::all_of(law.leeward.begin(), law.leeward.end(), usable) &&
         usable(law.friction) && usable(law.base_suction) && usable(law.shelter) && usable(law.curvature) && usable(law.layer * (1.0 + law.layer_curvature)) && divides(law.base_edge) &&
         divides(law.recovery_edge);
}

/// Whether the kernels can sum a law with a pillow.
bool in_kernels(const Law& law, const Pillow& pillow, Effects effects) {
  const bool shifted =
      effects.has(Effect::pillow) && pillow.form != PillowForm::none && (pillow.factor > 0.0 || pillow.form == PillowForm::eccentricity);
  return !(shifted && pillow.form != PillowForm::tilt) && fits(law) && never_negative(law.windward) &&
         (!effects.has(Effect::leeward_suction) || never_negative(law.leeward));
}

/// All numbers of a law but its name, which lie together.
bool same_numbers(const Law& a, const Law& b) {
  constexpr std::size_t count = 2 * std::tuple_size_v<Law::Polynomial> + 13;
  static_assert(sizeof(Law) == offsetof(Law, windward) + count * sizeof(double));
  return std::memcmp(&a.windward, &b.windward, count * sizeof(double)) == 0;
}
bool same(const Law& law, const Pillow& pillow, const Law& other_law, const Pillow& other_pillow) {
  return same_numbers(law, other_law) && pillow.form == other_pillow.form && pillow.falloff == other_pillow.falloff &&
         std::memcmp(&pillow.factor, &other_pillow.factor, sizeof(double)) == 0 &&
         std::memcmp(&pillow.viscous_gain, &other_pillow.viscous_gain, sizeof(double)) == 0;
}
bool same(const Model& a, const Model& b) {
  return a.quadrature == b.quadrature && a.effects == b.effects && same(a.law, a.pillow, b.law, b.pillow) &&
         a.sheets.has_value() == b.sheets.has_value() &&
         (!a.sheets || same(a.sheets->law, a.sheets->pillow, b.sheets->law, b.sheets->pillow));
}

FoldedModel fold(const Model& model) {
  FoldedModel folded;
  try {
    check_model(model);
    folded.valid = true;
  } catch (const std::invalid_argument&) {  // said again by who asks
  }
  folded.single = in_kernels(model.law, model.pillow, model.effects) &&
                  (!model.sheets || in_kernels(model.sheets->law, model.sheets->pillow, model.effects));
  return folded;
}

}  // namespace

const FoldedModel& FoldedModel::of(const Model& model) {
  struct Known {
    Model model;
    FoldedModel folded;
    bool used = false;
  };
  thread_local std::array<Known, 4> known;
  thread_local std::size_t latest = 0;
  for (std::size_t k = 0; k < known.size(); ++k)
    if (Known& entry = known[(latest + k) % known.size()]; entry.used && same(entry.model, model)) {
      latest = (latest + k) % known.size();
      return entry.folded;
    }
  latest = (latest + 1) % known.size();
  known[latest] = {model, fold(model), true};
  known[latest].model.correction.reset();  // not looked at here, and not to be kept alive
  return known[latest].folded;
}

}  // namespace dragcore
