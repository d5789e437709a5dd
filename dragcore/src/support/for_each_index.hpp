#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#ifdef DRAGCORE_THREADS
#include <tbb/parallel_for.h>
#endif

namespace dragcore {

/// Calls work(i) for every i below `count`, on the threads of the caller's arena where the library has any (DRAGCORE_THREADS).
/// @param grain  calls that a thread takes at once at least
template <class Work>
void for_each_index(std::size_t count, std::size_t grain, const Work& work) {
#ifdef DRAGCORE_THREADS
  if (count > grain) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const tbb::blocked_range<std::size_t>& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) work(i);
    });
    return;
  }
#endif
  static_cast<void>(grain);
  for (std::size_t i = 0; i < count; ++i) work(i);
}

/// A sum over groups of triangles: work(first, last, sum) for chunks of always the same size, added up in their order. So its bits do not
/// depend on the number of threads.
template <class Sum, class Work, class Add>
Sum in_chunks(std::size_t first, std::size_t last, const Work& work, const Add& add) {
  constexpr std::size_t chunk = 512;  // 8192 triangles: some ten microseconds, ten times what it takes to hand them over
  Sum all{};
  if (last - first <= chunk) {
    work(first, last, all);
    return all;
  }
  std::vector<Sum> sums((last - first + chunk - 1) / chunk);
  for_each_index(sums.size(), 1, [&](std::size_t k) { work(first + k * chunk, std::min(first + (k + 1) * chunk, last), sums[k]); });
  for (const Sum& sum : sums) add(all, sum);
  return all;
}

}  // namespace dragcore
