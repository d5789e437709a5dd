#include <dragcore/law.hpp>
#include <dragcore/unknown_word.hpp>
#include <stdexcept>

#include "support/require.hpp"

namespace dragcore {

// The same numbers, with where they come from, are in dragcore/laws/*.toml; tests/dragcore/io/test_law_file.cpp holds the two together.

Law note_law() { return {.name = "note", .windward = {0.0, 0.0, 2.0, -1.0, 0.0}}; }

Law consistent_law() { return {.name = "consistent", .windward = {0.0, 2.0, -1.0, 0.0, 0.0}}; }

Law sheet_law() {
  return {.name = "sheet",
          .windward = {0.0, 2.016, -0.83, 0.0, 0.0},
          .friction = 0.0025,
          .stokes = 1.0,
          .layer = 1.096,
          .layer_curvature = 0.583};
}

Law closed_law() {
  return {.name = "closed",
          .windward = {0.0, 0.0, 1.652, -0.826, 0.0},
          .friction = 0.003,
          .base_suction = 0.381,
          .recovery = 1.0,
          .recovery_depth = 0.626,
          .shelter = 1.698,
          .curvature = 0.819,
          .stokes = 1.0,
          .layer = 1.096,
          .layer_curvature = 0.583};
}

Law scaled_law(double windward_scale, double base_suction) {
  return {.name = "scaled",
          .windward = {0.0, 0.0, 2.0 * windward_scale, -windward_scale, 0.0},
          .leeward = {0.0, 2.0 * base_suction, -base_suction, 0.0, 0.0}};
}

Law law_for(BodyClass body_class) { return body_class == BodyClass::sheet ? sheet_law() : closed_law(); }

const std::vector<std::string>& law_names() {
  static const std::vector<std::string> names = {"note", "consistent", "sheet", "closed"};
  return names;
}

Law named_law(const std::string& name) {
  for (const Law& law : {note_law(), consistent_law(), sheet_law(), closed_law()})
    if (law.name == name) return law;
  throw std::invalid_argument(unknown_word("law", name, law_names()));
}

void validate(const Law& law) {
  const auto named = [&law](const char* name) { return [&law, name] { return "law '" + law.name + "': " + name; }; };
  for (const double coefficient : law.windward) require_finite(named("windward coefficient"), coefficient);
  for (const double coefficient : law.leeward) require_finite(named("leeward coefficient"), coefficient);
  const auto at_least_zero = [&](const char* name, double value) {
    require(value >= 0.0 && value < 1e6, named(name), value, "it must be from 0 to 1e6");
  };
  const auto positive = [&](const char* name, double value) {
    require(value > 0.0 && value < 1e6, named(name), value, "it must be greater than 0 and below 1e6");
  };
  at_least_zero("friction", law.friction);
  at_least_zero("base_suction", law.base_suction);
  positive("base_edge", law.base_edge);
  at_least_zero("aspect_gain", law.aspect_gain);
  positive("aspect_scale", law.aspect_scale);
  require(law.recovery >= 0.0 && law.recovery <= 1.0, named("recovery"), law.recovery, "it must be from 0 to 1");
  positive("recovery_depth", law.recovery_depth);
  positive("recovery_edge", law.recovery_edge);
  at_least_zero("shelter", law.shelter);
  at_least_zero("curvature", law.curvature);
  at_least_zero("stokes", law.stokes);
  at_least_zero("layer", law.layer);
  at_least_zero("layer_curvature", law.layer_curvature);
}

double evaluate(const Law::Polynomial& polynomial, double c) {
  double sum = 0.0;
  for (auto coefficient = polynomial.rbegin(); coefficient != polynomial.rend(); ++coefficient) sum = sum * c + *coefficient;
  return sum;
}

double derivative(const Law::Polynomial& polynomial, double c) {
  double sum = 0.0;
  for (std::size_t k = polynomial.size() - 1; k > 0; --k) sum = sum * c + static_cast<double>(k) * polynomial[k];
  return sum;
}

}  // namespace dragcore
