#pragma once

#include <array>
#include <cstddef>
#include <dragcore/surface.hpp>
#include <memory>
#include <vector>

namespace dragcore::kernels {

/// Numbers that start at a cache line, for vectors of any width.
template <class Number>
class Aligned {
 public:
  explicit Aligned(std::size_t size = 0)
      : size_(size), data_(size == 0 ? nullptr : static_cast<Number*>(::operator new(size * sizeof(Number), alignment))) {
    std::fill_n(data_.get(), size, Number{});
  }
  Number* data() { return data_.get(); }
  const Number* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  Number& operator[](std::size_t k) { return data_.get()[k]; }
  Number operator[](std::size_t k) const { return data_.get()[k]; }

 private:
  static constexpr std::align_val_t alignment{64};
  struct Free {
    void operator()(Number* data) const { ::operator delete(data, alignment); }
  };
  std::size_t size_;
  std::unique_ptr<Number, Free> data_;
};

/// Triangles of every part together, in single precision and structure of arrays. Lengths are in units of `size` about `origin`, areas of
/// `area`. Each part begins at a multiple of `lanes`; what fills up has no area.
struct PackedSurface {
  static constexpr std::size_t lanes = 16;  ///< of the widest vectors; narrower ones take them in turn, so that sums have the same bits
  struct Range {
    std::size_t first, last;
  };

  explicit PackedSurface(const Surface& surface);

  Eigen::Vector3d origin;
  double size, area;
  std::vector<Range> part;    ///< of every part
  std::vector<int> triangle;  ///< of the surface, of every place in the arrays; -1 for what fills up
  bool one_sided = true;      ///< no back feels the air
  bool by_triangle = false;   ///< facets are triangles: the surface has an exposure

  std::array<Aligned<float>, 3> normal, place, moment;  ///< place of the centroid; moment = place x normal
  Aligned<float> share;                                 ///< area
  Aligned<float> back;                                  ///< share of the area whose back feels the air
  std::array<Aligned<float>, 3> edge_ab, edge_ac;
  std::array<Aligned<float>, 6> second_moment;
  std::array<Aligned<float>, 6> curvature;  ///< times the root of (area of the part / pi): 1 all over a ball, along any tangent

  /// Of every part, for friction in uniform flow: wetted area, and its first moment about `origin`.
  std::vector<double> wetted;
  std::vector<Eigen::Vector3d> wetted_moment;

  /// What a silhouette is the sum of: a planar patch, or a triangle where each has its own share of the wind. Double precision: how slender
  /// a silhouette is comes from differences.
  struct Facets {
    std::vector<Range> part;
    std::vector<int> triangle;  ///< of every facet that is one
    std::array<Aligned<double>, 3> normal, first;
    std::array<Aligned<double>, 6> second;
    Aligned<double> area;
  } facets;
};

}  // namespace dragcore::kernels
