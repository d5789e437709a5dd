#pragma once

#include <string>

namespace dragcore {

/// What wrench() can take into account beside windward pressure. An effect is evaluated where the model allows it (`Model::effects`) and
/// the law, the pillow and the motion have it; otherwise its code does not run.
enum class Effect : unsigned {
  leeward_suction = 1u << 0,  ///< the law's polynomial L
  friction = 1u << 1,
  base_suction = 1u << 2,
  recovery = 1u << 3,
  shelter = 1u << 4,
  curvature = 1u << 5,
  pillow = 1u << 6,
  spin = 1u << 7,            ///< velocities of points differ by omega x r
  wind_variation = 1u << 8,  ///< the wind's gradient, or its values per triangle
  viscous = 1u << 9,         ///< Stokes' resistance and the boundary layer in place of `friction`, where the viscosity is known
  correction = 1u << 10,     ///< what one body was found to feel beyond the law: Correction
};

inline constexpr unsigned effect_count = 11;

/// A set of effects.
class Effects {
 public:
  constexpr Effects() = default;  ///< none
  constexpr Effects(Effect effect) : bits_(static_cast<unsigned>(effect)) {}
  static constexpr Effects all() { return Effects((1u << effect_count) - 1u); }

  constexpr bool has(Effect effect) const { return (bits_ & static_cast<unsigned>(effect)) != 0u; }
  constexpr bool empty() const { return bits_ == 0u; }
  constexpr unsigned bits() const { return bits_; }
  constexpr Effects operator|(Effects other) const { return Effects(bits_ | other.bits_); }
  constexpr Effects operator&(Effects other) const { return Effects(bits_ & other.bits_); }
  constexpr Effects without(Effects other) const { return Effects(bits_ & ~other.bits_); }
  constexpr bool operator==(const Effects&) const = default;

 private:
  constexpr explicit Effects(unsigned bits) : bits_(bits) {}
  unsigned bits_ = 0u;
};

constexpr Effects operator|(Effect left, Effect right) { return Effects(left) | Effects(right); }

std::string to_string(Effect effect);

}  // namespace dragcore
