#include "kernels/deforming_kernel.hpp"

#include <utility>

// This file is compiled once for every instruction set; the best one that the machine has is taken at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/deforming_kernel.cpp"
#include <hwy/foreach_target.h>

#include "kernels/law-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace dragcore::kernels::HWY_NAMESPACE {

namespace {

// ---- rows of four numbers, which gathers would fetch one by one

#if HWY_TARGET == HWY_SCALAR

struct Four {
  float at[4];
};
HWY_INLINE Four zero4() { return {}; }
HWY_INLINE Four load4(const float* from) { return {{from[0], from[1], from[2], 0.0f}}; }
HWY_INLINE Four add4(Four a, Four b) { return {{a.at[0] + b.at[0], a.at[1] + b.at[1], a.at[2] + b.at[2], 0.0f}}; }
HWY_INLINE Four sub4(Four a, Four b) { return {{a.at[0] - b.at[0], a.at[1] - b.at[1], a.at[2] - b.at[2], 0.0f}}; }
HWY_INLINE void store4(Four row, float* to) {
  for (int axis = 0; axis < 4; ++axis) to[axis] = row.at[axis];
}

HWY_INLINE Vec3 row(const float* rows, const std::uint32_t* offset) {
  const float* const at = rows + *offset;
  return {set(at[0]), set(at[1]), set(at[2])};
}
struct Edges {
  Vec3 ab, ac, u;
};
HWY_INLINE Edges edges(const float* rows, const CornerRows& corners, std::size_t lane) {
  const Vec3 a = row(rows, corners.of[0] + lane), b = row(rows, corners.of[1] + lane), c = row(rows, corners.of[2] + lane);
  const float* const flows = rows + vertex_row / 2;
  const V minus_one = set(-1.0f);
  return {along(b, minus_one, a), along(c, minus_one, a),
          add(add(row(flows, corners.of[0] + lane), row(flows, corners.of[1] + lane)), row(flows, corners.of[2] + lane))};
}
HWY_INLINE void store_rows(const Vec3& force, float* rows, std::size_t lane) {
  float* const to = rows + force_row * force_place(lane);
  to[0] = hn::GetLane(force.x), to[1] = hn::GetLane(force.y), to[2] = hn::GetLane(force.z), to[3] = 0.0f;
}

#else

constexpr hn::FixedTag<float, 4> four;
using Four = hn::Vec<hn::FixedTag<float, 4> >;
HWY_INLINE Four zero4() { return hn::Zero(four); }
HWY_INLINE Four load4(const float* from) { return hn::LoadU(four, from); }
HWY_INLINE Four add4(Four a, Four b) { return hn::Add(a, b); }
HWY_INLINE Four sub4(Four a, Four b) { return hn::Sub(a, b); }
HWY_INLINE void store4(Four row, float* to) { hn::Store(row, four, to); }

/// Rows of every fourth lane from the first on, side by side.
template <std::size_t count>
HWY_INLINE hn::Vec<hn::FixedTag<float, count> > blocks(const float* rows, const std::uint32_t* offset) {
  const hn::FixedTag<float, count> tag;
  if constexpr (count == 4)
    return hn::Load(tag, rows + *offset);
  else
    return hn::Combine(tag, blocks<count / 2>(rows, offset + count / 2), blocks<count / 2>(rows, offset));
}

/// Rows of all lanes, as blocks() has them of the first four, to a vector of each of their first three numbers.
HWY_INLINE Vec3 transposed(const V (&rows)[4]) {
  const V even = hn::InterleaveLower(f, rows[0], rows[2]), odd = hn::InterleaveLower(f, rows[1], rows[3]);
  return {hn::InterleaveLower(f, even, odd), hn::InterleaveUpper(f, even, odd),
          hn::InterleaveLower(f, hn::InterleaveUpper(f, rows[0], rows[2]), hn::InterleaveUpper(f, rows[1], rows[3]))};
}

struct Edges {
  Vec3 ab, ac, u;  ///< u: sum of the three corners
};
HWY_INLINE Edges edges(const float* rows, const CornerRows& corners, std::size_t lane) {
  V ab[4], ac[4], u[4];
  const float* const flows = rows + vertex_row / 2;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::uint32_t *const a = corners.of[0] + lane + k, *const b = corners.of[1] + lane + k, *const c = corners.of[2] + lane + k;
    const V start = blocks<width>(rows, a);
    ab[k] = hn::Sub(blocks<width>(rows, b), start);
    ac[k] = hn::Sub(blocks<width>(rows, c), start);
    u[k] = hn::Add(hn::Add(blocks<width>(flows, a), blocks<width>(flows, b)), blocks<width>(flows, c));
  }
  return {transposed(ab), transposed(ac), transposed(u)};
}

/// The way back: force_place() is the order in which this leaves them, whatever the width.
HWY_INLINE void store_rows(const Vec3& force, float* rows, std::size_t lane) {
  const V zero = hn::Zero(f);
  float* const to = rows + force_row * lane / 4;
  constexpr std::size_t next = force_row * lanes / 4;
  const V xz = hn::InterleaveLower(f, force.x, force.z), y = hn::InterleaveLower(f, force.y, zero);
  hn::Store(hn::InterleaveLower(f, xz, y), f, to), hn::Store(hn::InterleaveUpper(f, xz, y), f, to + next);
  const V upper_xz = hn::InterleaveUpper(f, force.x, force.z), upper_y = hn::InterleaveUpper(f, force.y, zero);
  hn::Store(hn::InterleaveLower(f, upper_xz, upper_y), f, to + 2 * next);
  hn::Store(hn::InterleaveUpper(f, upper_xz, upper_y), f, to + 3 * next);
}

#endif

// ---- effects: those of the law that are local

constexpr unsigned local_two_sided = 1, local_leeward = 2, local_base = 4, local_friction = 8, local_kernels = 16;

/// Where squares of areas and speeds, their products and roots are numbers of full precision; or where no air moves.
HWY_INLINE M fits(V area2, V speed2, V product) {
  const M sound = hn::And(hn::Ge(hn::Min(area2, speed2), set(1e-30f)), hn::Le(hn::Max(area2, speed2), set(1e18f)));
  const M still = hn::And(hn::Eq(speed2, hn::Zero(f)), hn::Le(area2, set(1e18f)));
  return hn::Or(hn::And(sound, hn::Ge(product, set(1e-36f))), still);
}

using OneByOne = void (*)(void* context, std::size_t triangle);

/// With N = ab x ac, twice the area along the normal, and d = u.N, what presses is -sign(w) N |u|^2 (C - f c) and what rubs f |u| |N| u:
/// the normal part of u, which does not rub, is worked into the first. So a triangle takes one root and, but for base suction, one
/// division.
template <unsigned on>
void force_rows(const DeformingTask& task, std::size_t first, std::size_t last, OneByOne one_by_one, void* context) {
  const LawLanes law(task.law);
  const V scale = set(task.scale), rubs = hn::Mul(law.skin_friction, set(on & local_two_sided ? 2.0f : 1.0f));
  for (std::size_t g = first; g < last; ++g)
    for (std::size_t lane = 0; lane < lanes; lane += width) {
      const Edges at = edges(task.vertex_rows, task.corners[g], lane);
      const Vec3 normal = cross(at.ab, at.ac);
      const V area2 = dot(normal, normal), speed2 = dot(at.u, at.u), d = dot(at.u, normal), product = hn::Mul(area2, speed2);
      const V root = hn::Sqrt(product), c = hn::Min(set(1.0f), hn::Div(hn::Abs(d), hn::Max(root, set(tiny))));
      const Windward front = windward < (on & local_base) ? base : 0u > (law, c, c, c, {c, c});
      V coefficient = front.pressure;
      if constexpr (on & local_base) coefficient = hn::Add(coefficient, front.base_suction);
      const V behind = on & local_leeward ? law.leeward(c) : hn::Zero(f);
      if constexpr (!(on & local_two_sided))
        coefficient = hn::IfThenElse(hn::Lt(d, hn::Zero(f)), coefficient, behind);
      else if constexpr ((on & local_leeward) != 0)
        coefficient = hn::Add(coefficient, behind);
      coefficient = hn::IfThenElseZero(hn::Gt(c, hn::Zero(f)), coefficient);
      if constexpr (on & local_friction) coefficient = hn::NegMulAdd(rubs, c, coefficient);
      const V downstream = hn::And(d, set(-0.0f));
      Vec3 force = times(normal, hn::Xor(hn::Mul(hn::Mul(scale, speed2), coefficient), downstream));
      if constexpr (on & local_friction) force = along(force, hn::Mul(hn::Mul(scale, rubs), root), at.u);
      store_rows(force, task.force_rows + force_row * lanes * g, lane);
      if (const M good = fits(area2, speed2, product); HWY_UNLIKELY(!hn::AllTrue(f, good))) {
        alignas(64) float done[width];
        hn::Store(hn::IfThenElseZero(good, set(1.0f)), f, done);
        for (std::size_t k = 0; k < width; ++k)
          if (done[k] == 0.0f) one_by_one(context, lanes * g + lane + k);
      }
    }
}

template <std::size_t... on>
constexpr auto table_of(std::index_sequence<on...>) {
  using Kernel = void (*)(const DeformingTask&, std::size_t, std::size_t, OneByOne, void*);
  struct Table {
    Kernel kernel[sizeof...(on)];
  };
  return Table{{&force_rows<on>...}};
}

}  // namespace

void fill_force_rows_on_target(const DeformingTask& task, std::size_t first, std::size_t last, OneByOne one_by_one, void* context) {
  static constexpr auto table = table_of(std::make_index_sequence<local_kernels>());
  const ResolvedLaw& law = task.law;
  const unsigned on = (task.two_sided ? local_two_sided : 0u) | (law.leeward ? local_leeward : 0u) | (law.base ? local_base : 0u) |
                      (law.friction ? local_friction : 0u);
  table.kernel[on](task, first, last, one_by_one, context);
}

void fill_vertex_rows_on_target(const DeformingTask& task, std::size_t first, std::size_t last) {
  const auto fill = [&](std::size_t vertex, const float* position, const float* velocity, const float* wind) {
    float* const to = task.vertex_rows + vertex_row * vertex;
    store4(load4(position), to);  // the fourth number is whatever comes next: nobody reads it
    store4(sub4(load4(wind), load4(velocity)), to + vertex_row / 2);
  };
  const auto at = [](const Strided& array, std::size_t vertex) { return array.first + array.stride * vertex; };
  const bool ends = last == task.vertices;
  for (std::size_t v = first; v < (ends ? last - 1 : last); ++v) fill(v, at(task.position, v), at(task.velocity, v), at(task.wind, v));
  if (!ends) return;
  // Nothing need come after the last vertex.
  float copies[3][4] = {};
  const Strided* const arrays[3] = {&task.position, &task.velocity, &task.wind};
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis) copies[k][axis] = at(*arrays[k], last - 1)[axis];
  fill(last - 1, copies[0], copies[1], copies[2]);
}

void sum_forces_on_target(const DeformingTask& task, std::size_t first, std::size_t last) {
  const float* const rows = task.force_rows;
  const std::uint32_t* next = task.incident + task.first[first];
  float* to = task.force + task.force_stride * first;
  for (std::size_t v = first; v < last; ++v, to += task.force_stride) {
    const std::uint32_t* const end = task.incident + task.first[v + 1];
    Four sum = zero4();
    for (; next != end; ++next) sum = add4(sum, load4(rows + *next));
    alignas(16) float found[4];
    store4(sum, found);
    to[0] = found[0], to[1] = found[1], to[2] = found[2];
  }
}

}  // namespace dragcore::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dragcore::kernels {

HWY_EXPORT(fill_vertex_rows_on_target);
HWY_EXPORT(fill_force_rows_on_target);
HWY_EXPORT(sum_forces_on_target);

void fill_vertex_rows(const DeformingTask& task, std::size_t first, std::size_t last) {
  HWY_DYNAMIC_DISPATCH(fill_vertex_rows_on_target)(task, first, last);
}
void fill_force_rows(const DeformingTask& task, std::size_t first, std::size_t last, void (*one_by_one)(void*, std::size_t),
                     void* context) {
  HWY_DYNAMIC_DISPATCH(fill_force_rows_on_target)(task, first, last, one_by_one, context);
}
void sum_forces(const DeformingTask& task, std::size_t first, std::size_t last) {
  HWY_DYNAMIC_DISPATCH(sum_forces_on_target)(task, first, last);
}

}  // namespace dragcore::kernels
#endif
