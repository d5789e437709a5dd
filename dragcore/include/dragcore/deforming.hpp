#pragma once

#include <Eigen/Core>
#include <concepts>
#include <cstddef>
#include <dragcore/drag.hpp>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace dragcore {

class FastDeforming;

/// A vector of every vertex in single precision, x y z, where an engine keeps it: side by side, padded to four numbers, or in the middle of
/// its own vertices. Not owned. A std::vector or std::span of Eigen::Vector3f is one.
/// @tparam Number  const float, or float where forces are to be written
template <class Number>
struct VertexArray {
  using Vector = std::conditional_t<std::is_const_v<Number>, const Eigen::Vector3f, Eigen::Vector3f>;

  Number* first = nullptr;  ///< x of the first vertex
  std::size_t count = 0;    ///< vertices
  std::size_t stride = 3;   ///< from one x to the next, in numbers: at least 3

  /// A template, so that {0, 0, 3} is a vector and no address.
  template <std::convertible_to<Number*> Pointer>
  requires std::is_pointer_v<Pointer> VertexArray(Pointer first_x, std::size_t vertices, std::size_t numbers_apart = 3)
      : first(first_x), count(vertices), stride(numbers_apart) {}
  template <class Vectors>
  requires std::constructible_from<std::span<Vector>, Vectors&> VertexArray(Vectors&& vectors) : VertexArray(std::span<Vector>(vectors)) {}
  VertexArray(std::span<Vector> vectors) : first(vectors.empty() ? nullptr : vectors.data()->data()), count(vectors.size()) {}

  Eigen::Map<Vector> operator[](std::size_t vertex) const { return Eigen::Map<Vector>(first + stride * vertex); }
};

/// The air on a mesh whose vertices move each by itself: cloth, sails, leaves. World frame; wherever the vertices are, areas and normals
/// are theirs in every call.
///
/// A triangle meets the air at the mean of what its corners do: u = mean(wind - velocity). On it act the terms of a law that are local to
/// it, pressure, suction, base suction and friction (eq. 2, 3, 9 and 12 of docs/model.md), and each of its corners gets a third of their
/// force. So what the vertices feel takes energy from their motion through the air and never gives any: the sum of force . (wind -
/// velocity) over them is not negative.
///
/// What depends on a body as a whole has no meaning while it deforms: pillow, aspect, rear recovery, shelter, curvature and the viscous
/// terms. So a medium whose viscosity is known is refused; the law's constant friction is what there is.
///
/// One object is one piece of cloth: it keeps what a call works with, so two threads may use two objects, not one. Large meshes are shared
/// out to the threads of the caller's arena (oneTBB, DRAGCORE_THREADS), and their number does not change a bit; nor do AVX2 and AVX-512.
class DeformingMesh {
 public:
  /// @param triangles  indices of vertices. Those that name a vertex twice carry no force
  /// @param sides      `two`, sheets: both sides of each triangle feel the air; `one`, skins of inflated bodies: the outer one, from which
  ///                   its corners run counterclockwise
  /// @throws std::invalid_argument  if an index is not below `vertices`, there are 2^28 vertices or triangles or more, or for
  ///                                Sides::automatic: a mesh that folds does not tell
  DeformingMesh(std::span<const Eigen::Vector3i> triangles, std::size_t vertices, Surface::Sides sides);
  DeformingMesh(DeformingMesh&&) noexcept;
  DeformingMesh& operator=(DeformingMesh&&) noexcept;
  ~DeformingMesh();

  /// Force of the air on every vertex [N], world frame; what was in `force` is written over. 0 where no triangle is.
  /// @param position  of the vertices [m]
  /// @param velocity  of the vertices [m/s]
  /// @param wind      velocity of the undisturbed air: everywhere, or at each vertex [m/s]
  /// @param law       sheet_law(), note_law(), consistent_law(), scaled_law(), or any with polynomials that are nowhere negative and
  ///                  without aspect_gain, recovery, shelter and curvature
  /// @throws std::invalid_argument  for another number of vertices, a law that needs a body, a negative density, and any number that is
  ///                                not finite where a triangle meets it: value found, value needed. `force` is then as it was
  /// @throws std::overflow_error    if a force is beyond 1e30 N; `force` is then as it was
  /// @accuracy  for coefficients of order 1, of each triangle 1e-6 of density/2 speed^2 times the square of its longest edge, against
  ///            reference::vertex_forces() (tests/dragcore/drag/test_deforming.cpp). Triangles whose numbers do not fit into single
  ///            precision, edges below some 0.01 mm or above 10 km, say, are summed in double, one at a time
  void forces(VertexArray<const float> position, VertexArray<const float> velocity, const Eigen::Vector3d& wind, const Medium& medium,
              const Law& law, VertexArray<float> force);
  void forces(VertexArray<const float> position, VertexArray<const float> velocity, VertexArray<const float> wind, const Medium& medium,
              const Law& law, VertexArray<float> force);

  std::size_t vertices() const { return vertices_; }
  std::span<const Eigen::Vector3i> triangles() const { return triangles_; }

 private:
  void sum_forces(VertexArray<const float> position, VertexArray<const float> velocity, VertexArray<const float> wind, const Medium& medium,
                  const Law& law, VertexArray<float> force);

  std::vector<Eigen::Vector3i> triangles_;
  std::size_t vertices_;
  bool two_sided_;
  std::unique_ptr<FastDeforming> fast_;  // null where the library was built without its kernels
};

namespace reference {

/// The same in double precision, triangle by triangle. Inputs are taken as they are, but for the numbers of vertices and the law.
std::vector<Eigen::Vector3d> vertex_forces(std::span<const Eigen::Vector3i> triangles, Surface::Sides sides,
                                           std::span<const Eigen::Vector3d> position, std::span<const Eigen::Vector3d> velocity,
                                           const Eigen::Vector3d& wind, const Medium& medium, const Law& law);

}  // namespace reference

}  // namespace dragcore
