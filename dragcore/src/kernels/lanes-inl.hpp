// Vectors of one instruction set, and small mathematics of them. Included once for every set: see wrench_kernel.cpp.
#if defined(DRAGCORE_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef DRAGCORE_LANES_INL
#undef DRAGCORE_LANES_INL
#else
#define DRAGCORE_LANES_INL
#endif

#include <hwy/highway.h>

#include <Eigen/Core>
#include <array>

#include "kernels/packed_surface.hpp"

HWY_BEFORE_NAMESPACE();
namespace dragcore::kernels::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, lanes>;
using V = hn::Vec<F>;
using M = hn::Mask<F>;
constexpr F f;
constexpr std::size_t width = hn::MaxLanes(F());

using D = hn::CappedTag<double, lanes / 2>;
using W = hn::Vec<D>;
constexpr D d;
constexpr std::size_t wide = hn::MaxLanes(D());

HWY_INLINE V set(float value) { return hn::Set(f, value); }
HWY_INLINE V load(const float* from) { return hn::Load(f, from); }

struct Vec3 {
  V x, y, z;
};
HWY_INLINE V dot(const Vec3& a, const Vec3& b) { return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z))); }
HWY_INLINE Vec3 cross(const Vec3& a, const Vec3& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)), hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
HWY_INLINE Vec3 add(const Vec3& a, const Vec3& b) { return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)}; }
/// a + s b
HWY_INLINE Vec3 along(const Vec3& a, V s, const Vec3& b) {
  return {hn::MulAdd(s, b.x, a.x), hn::MulAdd(s, b.y, a.y), hn::MulAdd(s, b.z, a.z)};
}
HWY_INLINE Vec3 times(const Vec3& a, V s) { return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)}; }
HWY_INLINE Vec3 set(const Eigen::Vector3f& v) { return {set(v.x()), set(v.y()), set(v.z())}; }
HWY_INLINE void store(const Vec3& v, Row (&rows)[3], std::size_t lane) {
  hn::Store(v.x, f, rows[0] + lane), hn::Store(v.y, f, rows[1] + lane), hn::Store(v.z, f, rows[2] + lane);
}

/// How a row of numbers becomes a vector: those of many triangles, or that of one triangle for many bodies.
struct Many {
  std::size_t lane;
  HWY_INLINE V operator()(const Row& row) const { return load(row + lane); }
};
struct One {
  std::size_t lane;
  HWY_INLINE V operator()(const Row& row) const { return set(row[lane]); }
};
template <class At>
HWY_INLINE Vec3 vector(const Row (&rows)[3], At at) {
  return {at(rows[0]), at(rows[1]), at(rows[2])};
}
/// The symmetric tensor xx, xy, xz, yy, yz, zz times a vector.
template <class At>
HWY_INLINE Vec3 apply(const Row (&tensor)[6], At at, const Vec3& v) {
  const V xy = at(tensor[1]), xz = at(tensor[2]), yz = at(tensor[4]);
  return {hn::MulAdd(at(tensor[0]), v.x, hn::MulAdd(xy, v.y, hn::Mul(xz, v.z))),
          hn::MulAdd(xy, v.x, hn::MulAdd(at(tensor[3]), v.y, hn::Mul(yz, v.z))),
          hn::MulAdd(xz, v.x, hn::MulAdd(yz, v.y, hn::Mul(at(tensor[5]), v.z)))};
}

/// Of degree four.
struct Polynomial {
  V p0, p1, p2, p3, p4;
  explicit HWY_INLINE Polynomial(const std::array<float, 5>& p)
      : p0(set(p[0])), p1(set(p[1])), p2(set(p[2])), p3(set(p[3])), p4(set(p[4])) {}
  HWY_INLINE V operator()(V c) const { return hn::MulAdd(hn::MulAdd(hn::MulAdd(hn::MulAdd(p4, c, p3), c, p2), c, p1), c, p0); }
};

/// Replaces n numbers by their reciprocals with one division [montgomery_1987, sec. 10.3.1].
template <std::size_t n>
HWY_INLINE void invert(V* number) {
  if constexpr (n > 0) {
    V product[n];
    product[0] = number[0];
    for (std::size_t k = 1; k < n; ++k) product[k] = hn::Mul(product[k - 1], number[k]);
    V rest = hn::Div(set(1.0f), product[n - 1]);
    for (std::size_t k = n - 1; k > 0; --k) {
      const V inverse = hn::Mul(rest, product[k - 1]);
      rest = hn::Mul(rest, number[k]);
      number[k] = inverse;
    }
    number[0] = rest;
  }
}

/// exp(-x) for x >= 0, within 2e-7: the same bits on every target with fused products.
HWY_INLINE V exp_minus(V x) {
  const V z = hn::Max(hn::Neg(x), set(-80.0f));
  const V n = hn::Round(hn::Mul(z, set(1.44269504f)));
  const V y = hn::MulAdd(n, set(2.12194440e-4f), hn::MulAdd(n, set(-0.693359375f), z));  // |y| <= log(2)/2, log(2) in two parts
  // 1 + y + y^2/2 + ... + y^6/720, by pairs: the sum waits for fewer products than by Horner's rule.
  const V y2 = hn::Mul(y, y), low = hn::Add(y, set(1.0f)), middle = hn::MulAdd(y, set(1.0f / 6.0f), set(0.5f)),
          high = hn::MulAdd(y2, set(1.0f / 720.0f), hn::MulAdd(y, set(1.0f / 120.0f), set(1.0f / 24.0f)));
  const V p = hn::MulAdd(y2, hn::MulAdd(y2, high, middle), low);
  const hn::RebindToSigned<F> i;
  return hn::BitCast(f, hn::Add(hn::BitCast(i, p), hn::ShiftLeft<23>(hn::ConvertTo(i, n))));
}

/// Sums of 16 lanes as 8 numbers in double: lane k, then lane k + 8, whatever the width.
/// @param lane  of the vector's first number
HWY_INLINE void add_to(double (&row)[lanes / 2], V sum, std::size_t lane) {
  const hn::Rebind<float, D> half;
  alignas(64) float number[width];
  hn::Store(sum, f, number);
  for (std::size_t k = 0; k < width; k += wide) {
    double* place = row + (lane + k) % (lanes / 2);
    hn::Store(hn::Add(hn::Load(d, place), hn::PromoteTo(d, hn::Load(half, number + k))), d, place);
  }
}

/// Of an aligned row, in one order whatever the width: the second half onto the first, until one is left.
template <std::size_t count>
HWY_INLINE double total(double* row) {
  std::size_t half = count / 2;
  for (; half >= wide; half /= 2)
    for (std::size_t k = 0; k < half; k += wide) hn::Store(hn::Add(hn::Load(d, row + k), hn::Load(d, row + k + half)), d, row + k);
  for (; half > 0; half /= 2)
    for (std::size_t k = 0; k < half; ++k) row[k] += row[k + half];
  return row[0];
}

}  // namespace dragcore::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
