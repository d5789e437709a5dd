#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <dragcore/effects.hpp>

// Two switches for the tests that prove what effects cost when they are off; neither is for users.
//   DRAGCORE_WITHOUT_EFFECTS  bits of effects whose code is left out of the build
//   DRAGCORE_COUNT_EFFECTS    counts how often the code of each effect runs
#ifndef DRAGCORE_WITHOUT_EFFECTS
#define DRAGCORE_WITHOUT_EFFECTS 0u
#endif

namespace dragcore::instrument {

constexpr bool built(Effect effect) { return (static_cast<unsigned>(effect) & (DRAGCORE_WITHOUT_EFFECTS)) == 0u; }

#ifdef DRAGCORE_COUNT_EFFECTS
inline thread_local std::array<std::uint64_t, effect_count> evaluations{};
inline void count(Effect effect) { ++evaluations[static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(effect)))]; }
#else
inline void count(Effect) {}
#endif

}  // namespace dragcore::instrument
