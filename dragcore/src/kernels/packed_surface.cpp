#include "kernels/packed_surface.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>

#include "body/pack.hpp"
#include "support/cross_matrix.hpp"
#include "support/triangle_second_moment.hpp"

namespace dragcore::kernels {

using Eigen::Index;
using Eigen::Vector3d;
using PackedPart = PackedSurface::Part;
using Range = PackedSurface::Range;

namespace {

constexpr std::size_t facet_lanes = lanes / 2;

std::size_t filled_up(std::size_t count, std::size_t multiple) { return (count + multiple - 1) / multiple * multiple; }

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

/// Lays items out part by part, each part from a multiple of `multiple` on: which item is at every place, -1 where none is.
template <class PartOf>
std::vector<int> lay_out(std::size_t items, std::size_t multiple, PartOf&& part_of, std::vector<Range>& ranges) {
  std::vector<std::size_t> count(ranges.size(), 0);
  for (std::size_t i = 0; i < items; ++i) ++count[part_of(i)];
  std::size_t size = 0;
  std::vector<std::size_t> next;
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    ranges[p] = {size, size + filled_up(count[p], multiple)};
    next.push_back(size);
    size = ranges[p].last;
  }
  std::vector<int> item(size, -1);
  for (std::size_t i = 0; i < items; ++i) item[next[part_of(i)]++] = static_cast<int>(i);
  return item;
}

template <std::size_t n, class Numbers>
void store(Row (&rows)[n], std::size_t lane, const Numbers& numbers) {
  for (std::size_t k = 0; k < n; ++k) rows[k][lane] = static_cast<float>(numbers[static_cast<Index>(k)]);
}

template <std::size_t n, class Numbers>
void store(std::array<Aligned<double>, n>& arrays, std::size_t slot, const Numbers& numbers) {
  for (std::size_t k = 0; k < n; ++k) arrays[k][slot] = numbers[static_cast<Index>(k)];
}

/// Whether a flow without gradient cannot tell two triangles of one patch apart, but for their areas and places.
bool alike(const Group& a, std::size_t i, const Group& b, std::size_t k) {
  const auto near = [&](const auto& one, const auto& other) {
    float largest = 0.0f, differs = 0.0f;
    for (std::size_t row = 0; row < std::size(one); ++row) {
      largest = std::max(largest, std::abs(one[row][i]));
      differs = std::max(differs, std::abs(one[row][i] - other[row][k]));
    }
    return differs <= 1e-6f * largest;  // a tenth of it is what rounding to float leaves
  };
  return near(a.normal, b.normal) && near(a.second_moment, b.second_moment) && near(a.curvature, b.curvature) && a.back[i] == b.back[k];
}

/// Triangles of one patch that a flow without gradient cannot tell apart as one, with the area and the moment of all. Returns nothing where
/// that leaves more than half of them.
Aligned<Group> merge(const PackedSurface& packed, std::vector<PackedPart>& parts, const std::vector<int>& patch) {
  struct Facet {
    std::size_t slot;  // of the triangle that stands for all
    double area;
    std::array<double, 3> first;  // area times moment
  };
  std::vector<Group> result;
  for (PackedPart& part : parts) {
    std::unordered_map<int, std::vector<Facet>> of_patch;
    std::size_t triangles = 0, found = 0;
    for (std::size_t slot = part.groups.first * lanes; slot < part.groups.last * lanes; ++slot) {
      if (packed.triangle[slot] < 0) continue;
      const Group& group = packed.groups[slot / lanes];
      const std::size_t lane = slot % lanes;
      std::vector<Facet>& facets = of_patch[patch[static_cast<std::size_t>(packed.triangle[slot])]];
      auto facet = std::find_if(facets.begin(), facets.end(), [&](const Facet& known) {
        return alike(packed.groups[known.slot / lanes], known.slot % lanes, group, lane);
      });
      if (facet == facets.end()) {
        if (facets.size() == 8) return Aligned<Group>();  // no two are alike here, and looking for one takes longer with each
        ++found, facet = facets.insert(facet, Facet{.slot = slot, .area = 0.0, .first = {}});
      }
      ++triangles;
      facet->area += group.share[lane];
      for (std::size_t axis = 0; axis < 3; ++axis) facet->first[axis] += static_cast<double>(group.share[lane]) * group.moment[axis][lane];
    }
    if (2 * found > triangles) return Aligned<Group>();
    part.uniform.first = result.size();
    std::size_t lane = lanes;
    for (std::size_t slot = part.groups.first * lanes; slot < part.groups.last * lanes; ++slot) {
      if (packed.triangle[slot] < 0) continue;
      for (const Facet& facet : of_patch[patch[static_cast<std::size_t>(packed.triangle[slot])]]) {
        if (facet.slot != slot) continue;
        if (lane == lanes) result.emplace_back(), lane = 0;
        Group& group = result.back();
        const Group& from = packed.groups[slot / lanes];
        const auto copy = [&](auto& rows, const auto& given) {
          for (std::size_t row = 0; row < std::size(rows); ++row) rows[row][lane] = given[row][slot % lanes];
        };
        copy(group.normal, from.normal), copy(group.second_moment, from.second_moment), copy(group.curvature, from.curvature);
        group.back[lane] = from.back[slot % lanes];
        group.share[lane] = static_cast<float>(facet.area);
        for (std::size_t axis = 0; axis < 3; ++axis)
          group.moment[axis][lane] = facet.area > 0.0 ? static_cast<float>(facet.first[axis] / facet.area) : 0.0f;
        ++lane;
      }
    }
    for (; lane < lanes; ++lane) result.back().normal[0][lane] = 1.0f;
    part.uniform.last = result.size();
  }
  Aligned<Group> aligned(result.size());
  std::copy(result.begin(), result.end(), aligned.data());
  return aligned;
}

}  // namespace

PackedSurface::PackedSurface(const Surface& surface) : parts(surface.parts.size()), by_triangle(surface.exposure != nullptr) {
  const auto part_of = [&](std::size_t i) { return static_cast<std::size_t>(surface.part[i]); };
  const auto count = static_cast<std::size_t>(surface.size());
  std::vector<Range> slots(parts.size());
  triangle = lay_out(count, lanes, part_of, slots);
  groups = Aligned<Group>(triangle.size() / lanes), places = Aligned<GroupPlace>(triangle.size() / lanes);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    Part& part = parts[p];
    const dragcore::Part& whole = surface.parts[p];
    part.groups = part.uniform = {slots[p].first / lanes, slots[p].last / lanes};
    part.origin = whole.centre;
    if (whole.radius > 0.0) part.size = whole.radius;
    if (whole.area > 0.0) part.area = whole.area;
    const double bend = std::sqrt(part.area / std::numbers::pi);
    // Neighbours by normal: those of a closed body that turn away from the air then come in groups, which cost nothing.
    const auto first = triangle.begin() + static_cast<std::ptrdiff_t>(slots[p].first);
    const auto last = std::find(first, triangle.begin() + static_cast<std::ptrdiff_t>(slots[p].last), -1);
    std::vector<std::pair<std::uint32_t, int>> order;
    for (auto t = first; t != last; ++t) order.emplace_back(place_on_sphere(surface.normal.row(*t).matrix()), *t);
    std::sort(order.begin(), order.end());
    std::transform(order.begin(), order.end(), first, [](const auto& entry) { return entry.second; });
    for (std::size_t slot = slots[p].first; slot < slots[p].last; ++slot) {
      Group& group = groups[slot / lanes];
      GroupPlace& place = places[slot / lanes];
      const std::size_t lane = slot % lanes;
      if (triangle[slot] < 0) {
        group.normal[0][lane] = 1.0f;
        continue;
      }
      const Index i = triangle[slot];
      const Vector3d n = surface.normal.row(i).matrix(), r = (Vector3d(surface.centroid.row(i).matrix()) - part.origin) / part.size;
      store(group.normal, lane, n), store(group.moment, lane, Vector3d(r.cross(n))), store(place.place, lane, r);
      store(place.edge_ab, lane, surface.edge_ab.row(i) / part.size), store(place.edge_ac, lane, surface.edge_ac.row(i) / part.size);
      store(group.second_moment, lane, surface.second_moment.row(i) / (part.size * part.size));
      store(group.curvature, lane, surface.curvature.row(i) * bend);
      group.share[lane] = static_cast<float>(surface.area[i] / part.area), group.back[lane] = static_cast<float>(surface.back[i]);
      part.two_sided |= surface.back[i] > 0.0;
      part.curved |= (surface.curvature.row(i) != 0.0).any();
      const Eigen::Matrix3d tangential =
          surface.area[i] / part.area * (1.0 + surface.back[i]) * (Eigen::Matrix3d::Identity() - n * n.transpose());
      part.friction_force += tangential, part.friction_torque += cross_matrix(r) * tangential;
    }
  }
  if (!by_triangle) merged = merge(*this, parts, surface.patch);
  if (merged.size() == 0)
    for (Part& part : parts) part.uniform = part.groups;

  std::vector<Range> facet_slots(parts.size());
  std::vector<int> item = by_triangle ? lay_out(count, facet_lanes, part_of, facet_slots)
                                      : lay_out(
                                            surface.patches.size(), facet_lanes,
                                            [&](std::size_t i) { return static_cast<std::size_t>(surface.patches[i].part); }, facet_slots);
  const auto resize = [&](auto& arrays) {
    for (Aligned<double>& array : arrays) array = Aligned<double>(item.size());
  };
  resize(facets.normal), resize(facets.first), resize(facets.second);
  facets.area = Aligned<double>(item.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    Part& part = parts[p];
    part.facets = facet_slots[p];
    const auto facet = [&](std::size_t slot, const Vector3d& n, const Vector3d& centre, double area, const Eigen::Matrix3d& own) {
      const Vector3d r = (centre - part.origin) / part.size;
      const Eigen::Matrix3d second = own / (part.size * part.size) + r * r.transpose();
      store(facets.normal, slot, n), store(facets.first, slot, r);
      store(facets.second, slot,
            Eigen::Vector<double, 6>(second(0, 0), second(0, 1), second(0, 2), second(1, 1), second(1, 2), second(2, 2)));
      facets.area[slot] = area / part.area;
    };
    for (std::size_t slot = part.facets.first; slot < part.facets.last; ++slot) {
      if (item[slot] < 0) continue;
      if (by_triangle) {
        const Index i = item[slot];
        facet(slot, surface.normal.row(i).matrix(), surface.centroid.row(i).matrix(), surface.area[i],
              triangle_second_moment(Vector3d(surface.edge_ab.row(i).matrix()), Vector3d(surface.edge_ac.row(i).matrix())));
      } else {
        const Patch& patch = surface.patches[static_cast<std::size_t>(item[slot])];
        facet(slot, patch.normal, patch.centroid, patch.area, patch.second_moment);
      }
    }
  }
  if (by_triangle) facets.triangle = std::move(item);
}

std::shared_ptr<const PackedSurface> pack(const Surface& surface) { return std::make_shared<PackedSurface>(surface); }

}  // namespace dragcore::kernels
