#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace dragcore::bench {

/// Products and sums in single precision, `rounds` times a fixed block of them that wait for nothing but the units. @return how many
double multiply_and_add(std::size_t rounds);
/// Lanes of the vectors that this machine's best, or the forced, instruction set has.
std::size_t float_lanes();

/// Reads all numbers of an array once, as `streams` parts side by side, and nothing else. @return their sum: each counts
float read_all(const float* first, std::size_t size, std::size_t streams);

/// Bytes of what this machine calls its caches, of one core: first, second, third level.
std::vector<double> cache_sizes();

}  // namespace dragcore::bench
