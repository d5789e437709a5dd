#include <dragcore/law.hpp>

#include <stdexcept>

namespace dragcore {

Law note_law() { return {.name = "note", .windward = {0.0, 0.0, 2.0, -1.0, 0.0}}; }

Law consistent_law() { return {.name = "consistent", .windward = {0.0, 2.0, -1.0, 0.0, 0.0}}; }

Law scaled_law(double windward_scale, double base_suction) {
  return {.name = "scaled",
          .windward = {0.0, 0.0, 2.0 * windward_scale, -windward_scale, 0.0},
          .leeward = {0.0, 2.0 * base_suction, -base_suction, 0.0, 0.0}};
}

Law named_law(const std::string& name) {
  if (name == "note") return note_law();
  if (name == "consistent") return consistent_law();
  throw std::invalid_argument("unknown law '" + name + "'; known: note, consistent");
}

double evaluate(const Law::Polynomial& polynomial, double c) {
  double sum = 0.0;
  for (auto coefficient = polynomial.rbegin(); coefficient != polynomial.rend(); ++coefficient) sum = sum * c + *coefficient;
  return sum;
}

}  // namespace dragcore
