#include "kernels/packed_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "body/pack.hpp"
#include "support/triangle_second_moment.hpp"

namespace dragcore::kernels {

using Eigen::Vector3d;

namespace {

std::size_t filled_up(std::size_t count) { return (count + PackedSurface::lanes - 1) / PackedSurface::lanes * PackedSurface::lanes; }

template <class Number, std::size_t n>
void resize(std::array<Aligned<Number>, n>& arrays, std::size_t size) {
  for (Aligned<Number>& array : arrays) array = Aligned<Number>(size);
}

template <class Number, std::size_t n, class Row>
void store(std::array<Aligned<Number>, n>& arrays, std::size_t slot, const Row& row) {
  for (std::size_t k = 0; k < n; ++k) arrays[k][slot] = static_cast<Number>(row[static_cast<Eigen::Index>(k)]);
}

/// Directions that are near each other mostly have numbers that are near: along a curve through the faces of an octahedron.
std::uint32_t place_on_sphere(const Vector3d& direction) {
  const double sum = direction.cwiseAbs().sum();
  double x = direction.x() / sum, y = direction.y() / sum;
  if (direction.z() < 0.0) {
    const double folded = (1.0 - std::abs(y)) * std::copysign(1.0, x);
    y = (1.0 - std::abs(x)) * std::copysign(1.0, y);
    x = folded;
  }
  const auto step = [](double t) { return static_cast<std::uint32_t>(std::clamp((t + 1.0) * 512.0, 0.0, 1023.0)); };
  std::uint32_t code = 0;
  for (std::uint32_t bit = 0; bit < 10; ++bit) code |= (step(x) >> bit & 1u) << (2 * bit) | (step(y) >> bit & 1u) << (2 * bit + 1);
  return code;
}

/// Where each item of every part goes: all of one part together, in their order. Returns the length of the arrays.
template <class PartOf>
std::size_t lay_out(std::size_t items, std::size_t parts, PartOf&& part_of, std::vector<PackedSurface::Range>& ranges,
                    std::vector<int>& item) {
  std::vector<std::size_t> count(parts, 0);
  for (std::size_t i = 0; i < items; ++i) ++count[part_of(i)];
  std::size_t size = 0;
  std::vector<std::size_t> next;
  for (std::size_t p = 0; p < parts; ++p) {
    ranges.push_back({size, size + filled_up(count[p])});
    next.push_back(size);
    size = ranges.back().last;
  }
  item.assign(size, -1);
  for (std::size_t i = 0; i < items; ++i) item[next[part_of(i)]++] = static_cast<int>(i);
  return size;
}

}  // namespace

PackedSurface::PackedSurface(const Surface& surface)
    : origin(surface.centre), size(surface.radius > 0.0 ? surface.radius : 1.0), area(surface.total_area > 0.0 ? surface.total_area : 1.0) {
  const std::size_t parts = surface.parts.size();
  const std::size_t slots = lay_out(
      static_cast<std::size_t>(surface.size()), parts, [&](std::size_t i) { return static_cast<std::size_t>(surface.part[i]); }, part,
      triangle);
  // Neighbours by normal: those of a closed body that turn away from the air then come in groups, which cost nothing.
  for (const Range& range : part) {
    const auto first = triangle.begin() + static_cast<std::ptrdiff_t>(range.first);
    const auto last = std::find(first, triangle.begin() + static_cast<std::ptrdiff_t>(range.last), -1);
    std::vector<std::pair<std::uint32_t, int>> order;
    for (auto t = first; t != last; ++t) order.emplace_back(place_on_sphere(surface.normal.row(*t).matrix()), *t);
    std::sort(order.begin(), order.end());
    std::transform(order.begin(), order.end(), first, [](const auto& entry) { return entry.second; });
  }
  resize(normal, slots), resize(place, slots), resize(moment, slots), resize(edge_ab, slots), resize(edge_ac, slots);
  resize(second_moment, slots), resize(curvature, slots);
  share = Aligned<float>(slots), back = Aligned<float>(slots);
  wetted.assign(parts, 0.0), wetted_moment.assign(parts, Vector3d::Zero());
  for (std::size_t p = 0; p < parts; ++p) {
    const double bend = std::sqrt(surface.parts[p].area / std::numbers::pi);
    for (std::size_t slot = part[p].first; slot < part[p].last; ++slot) {
      if (triangle[slot] < 0) {
        store(normal, slot, Vector3d::UnitX());
        continue;
      }
      const Eigen::Index i = triangle[slot];
      const Vector3d n = surface.normal.row(i).matrix(), r = (Vector3d(surface.centroid.row(i).matrix()) - origin) / size;
      store(normal, slot, n), store(place, slot, r), store(moment, slot, Vector3d(r.cross(n)));
      store(edge_ab, slot, surface.edge_ab.row(i) / size), store(edge_ac, slot, surface.edge_ac.row(i) / size);
      store(second_moment, slot, surface.second_moment.row(i) / (size * size)), store(curvature, slot, surface.curvature.row(i) * bend);
      share[slot] = static_cast<float>(surface.area[i] / area), back[slot] = static_cast<float>(surface.back[i]);
      one_sided = one_sided && surface.back[i] == 0.0;
      const double wet = surface.area[i] / area * (1.0 + surface.back[i]);
      wetted[p] += wet, wetted_moment[p] += wet * r;
    }
  }

  by_triangle = surface.exposure != nullptr;
  std::vector<int> item;
  const std::size_t found = by_triangle
                                ? lay_out(
                                      static_cast<std::size_t>(surface.size()), parts,
                                      [&](std::size_t i) { return static_cast<std::size_t>(surface.part[i]); }, facets.part, item)
                                : lay_out(
                                      surface.patches.size(), parts,
                                      [&](std::size_t i) { return static_cast<std::size_t>(surface.patches[i].part); }, facets.part, item);
  resize(facets.normal, found), resize(facets.first, found), resize(facets.second, found);
  facets.area = Aligned<double>(found);
  const auto facet = [&](std::size_t slot, const Vector3d& n, const Vector3d& centre, double a, const Eigen::Matrix3d& own) {
    const Vector3d r = centre / size;
    const Eigen::Matrix3d second = own / (size * size) + r * r.transpose();
    store(facets.normal, slot, n), store(facets.first, slot, r);
    store(facets.second, slot,
          Eigen::Vector<double, 6>(second(0, 0), second(0, 1), second(0, 2), second(1, 1), second(1, 2), second(2, 2)));
    facets.area[slot] = a / area;
  };
  for (std::size_t p = 0; p < parts; ++p)
    for (std::size_t slot = facets.part[p].first; slot < facets.part[p].last; ++slot) {
      if (item[slot] < 0) continue;
      const Vector3d& about = surface.parts[p].centre;
      if (by_triangle) {
        const Eigen::Index i = item[slot];
        const Vector3d ab = surface.edge_ab.row(i).matrix(), ac = surface.edge_ac.row(i).matrix();
        facet(slot, surface.normal.row(i).matrix(), Vector3d(surface.centroid.row(i).matrix()) - about, surface.area[i],
              triangle_second_moment(ab, ac));
      } else {
        const Patch& patch = surface.patches[static_cast<std::size_t>(item[slot])];
        facet(slot, patch.normal, patch.centroid - about, patch.area, patch.second_moment);
      }
    }
  if (by_triangle) facets.triangle = std::move(item);
}

std::shared_ptr<const PackedSurface> pack(const Surface& surface) { return std::make_shared<PackedSurface>(surface); }

}  // namespace dragcore::kernels
