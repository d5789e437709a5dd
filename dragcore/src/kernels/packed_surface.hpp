#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <dragcore/surface.hpp>
#include <memory>
#include <new>
#include <vector>

namespace dragcore::kernels {

/// Of the widest vectors; narrower ones take them in turn, so that sums have the same bits.
inline constexpr std::size_t lanes = 16;
using Row = float[lanes];

/// Items that start at a cache line, zero at first.
template <class Item>
class Aligned {
 public:
  explicit Aligned(std::size_t size = 0)
      : size_(size), data_(size == 0 ? nullptr : static_cast<Item*>(::operator new(size * sizeof(Item), alignment))) {
    std::fill_n(data_.get(), size, Item{});
  }
  Item* data() { return data_.get(); }
  const Item* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  Item& operator[](std::size_t k) { return data_.get()[k]; }
  const Item& operator[](std::size_t k) const { return data_.get()[k]; }

 private:
  static constexpr std::align_val_t alignment{64};
  struct Free {
    void operator()(Item* data) const { ::operator delete(data, alignment); }
  };
  std::size_t size_;
  std::unique_ptr<Item, Free> data_;
};

/// Sixteen triangles of one part, a cache line for every number. Lengths are in units of the part's size, areas of its area; places from
/// its origin. What fills up has no area.
struct alignas(64) Group {
  Row normal[3];
  Row share;      ///< area
  Row moment[3];  ///< place of the centroid x normal
  Row second_moment[6];
  Row curvature[6];  ///< times the root of (area of the part / pi): 1 all over a ball, along any tangent
  Row back;          ///< share of the area whose back feels the air
};

/// What else they are where the flow varies over them.
struct alignas(64) GroupPlace {
  Row place[3];  ///< of the centroid
  Row edge_ab[3], edge_ac[3];
};

/// The triangles of a surface part by part, in single precision, as the kernels want them.
struct PackedSurface {
  struct Range {
    std::size_t first = 0, last = 0;
    std::size_t size() const { return last - first; }
  };
  struct Part {
    Range groups;
    Range uniform;  ///< the same in `uniform_groups`
    Range facets;
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< its centre [m]
    double size = 1.0;                                 ///< its radius [m]
    double area = 1.0;                                 ///< [m^2]
    bool two_sided = false;                            ///< some back feels the air
    bool curved = false;                               ///< some triangle has a curvature
    /// Friction in a flow along a unit vector, per coefficient: what of it each wetted side turns along itself, and the moment of that
    /// about `origin`.
    Eigen::Matrix3d friction_force = Eigen::Matrix3d::Zero(), friction_torque = Eigen::Matrix3d::Zero();
  };

  explicit PackedSurface(const Surface& surface);

  std::vector<Part> parts;
  Aligned<Group> groups;
  Aligned<GroupPlace> places;
  std::vector<int> triangle;  ///< of the surface, of every lane of `groups`; -1 for what fills up
  /// As far as a flow without gradient can tell: triangles of one plane and region are one. Empty where that saves nothing.
  Aligned<Group> merged;
  bool by_triangle = false;  ///< facets are triangles: the surface has an exposure

  const Group* uniform_groups() const { return merged.size() > 0 ? merged.data() : groups.data(); }

  /// What a silhouette is the sum of: a planar patch, or a triangle where each has its own share of the wind. Double precision: how slender
  /// a silhouette is comes from differences. Each part begins at a multiple of 8.
  struct Facets {
    std::vector<int> triangle;  ///< of every facet that is one
    std::array<Aligned<double>, 3> normal, first;
    std::array<Aligned<double>, 6> second;
    Aligned<double> area;
  } facets;
};

}  // namespace dragcore::kernels
