#include "machine.hpp"

#include <unistd.h>

// Compiled once for every instruction set, as the kernels are.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "machine.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace dragcore::bench::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
constexpr hn::ScalableTag<float> f;
using V = hn::Vec<decltype(f)>;

std::size_t Lanes() { return hn::Lanes(f); }

/// Ten chains: two units with a latency of four or five cycles each are kept busy. Values tend to 1 and stay there.
double Fma(std::size_t rounds) {
  const V half = hn::Set(f, 0.5f);
  V a = hn::Set(f, 0.1f), b = hn::Set(f, 0.2f), c = hn::Set(f, 0.3f), d = hn::Set(f, 0.4f), e = hn::Set(f, 0.6f);
  V g = hn::Set(f, 0.7f), h = hn::Set(f, 0.8f), i = hn::Set(f, 0.9f), j = hn::Set(f, 1.1f), k = hn::Set(f, 1.2f);
  for (std::size_t round = 0; round < rounds; ++round) {
    a = hn::MulAdd(a, half, half), b = hn::MulAdd(b, half, half), c = hn::MulAdd(c, half, half), d = hn::MulAdd(d, half, half);
    e = hn::MulAdd(e, half, half), g = hn::MulAdd(g, half, half), h = hn::MulAdd(h, half, half), i = hn::MulAdd(i, half, half);
    j = hn::MulAdd(j, half, half), k = hn::MulAdd(k, half, half);
  }
  const V sum = hn::Add(hn::Add(hn::Add(hn::Add(a, b), hn::Add(c, d)), hn::Add(hn::Add(e, g), hn::Add(h, i))), hn::Add(j, k));
  volatile float kept = hn::GetLane(sum);  // so that the loop is not optimised away
  (void)kept;
  return 2.0 * 10.0 * static_cast<double>(rounds * Lanes());
}

/// Four sums, so that additions do not wait for each other while the caches answer in time.
template <std::size_t streams>
float ReadStreams(const float* HWY_RESTRICT first, std::size_t size) {
  const std::size_t part = size / streams / (4 * Lanes()) * (4 * Lanes()), N = Lanes();
  V s0 = hn::Zero(f), s1 = s0, s2 = s0, s3 = s0;
  for (std::size_t at = 0; at < part; at += 4 * N)
    for (std::size_t stream = 0; stream < streams; ++stream) {
      const float* here = first + stream * part + at;
      s0 = hn::Add(s0, hn::LoadU(f, here)), s1 = hn::Add(s1, hn::LoadU(f, here + N));
      s2 = hn::Add(s2, hn::LoadU(f, here + 2 * N)), s3 = hn::Add(s3, hn::LoadU(f, here + 3 * N));
    }
  return hn::GetLane(hn::SumOfLanes(f, hn::Add(hn::Add(s0, s1), hn::Add(s2, s3))));
}

float Read(const float* first, std::size_t size, std::size_t streams) {
  return streams == 1 ? ReadStreams<1>(first, size) : ReadStreams<7>(first, size);
}

}  // namespace dragcore::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dragcore::bench {

HWY_EXPORT(Fma);
HWY_EXPORT(Lanes);
HWY_EXPORT(Read);

double multiply_and_add(std::size_t rounds) { return HWY_DYNAMIC_DISPATCH(Fma)(rounds); }
std::size_t float_lanes() { return HWY_DYNAMIC_DISPATCH(Lanes)(); }
float read_all(const float* first, std::size_t size, std::size_t streams) { return HWY_DYNAMIC_DISPATCH(Read)(first, size, streams); }

std::vector<double> cache_sizes() {
  std::vector<double> sizes;
  for (const int level : {_SC_LEVEL1_DCACHE_SIZE, _SC_LEVEL2_CACHE_SIZE, _SC_LEVEL3_CACHE_SIZE})
    sizes.push_back(static_cast<double>(sysconf(level)));
  return sizes;
}

}  // namespace dragcore::bench
#endif
