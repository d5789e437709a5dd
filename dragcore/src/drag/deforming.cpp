#include <algorithm>
#include <array>
#include <dragcore/deforming.hpp>
#include <stdexcept>
#include <string>

#include "drag/fast_deforming.hpp"
#include "drag/folded_model.hpp"
#include "support/require.hpp"

namespace dragcore {

using Eigen::Vector3d;

namespace {

constexpr std::size_t largest_mesh = std::size_t{1} << 28;  // eight numbers of each must be counted in 32 bits

void check_sides(Surface::Sides sides) {
  require(sides == Surface::Sides::one || sides == Surface::Sides::two, "DeformingMesh: sides", static_cast<int>(sides),
          "it must be 1 or 2: a mesh that folds does not tell");
}

void check_law(const Law& law) {
  validate(law);
  const auto named = [&law](const char* name) { return [&law, name] { return "DeformingMesh: law '" + law.name + "': " + name; }; };
  const auto absent = [&](const char* name, double value) {
    require(value == 0.0, named(name), value,
            "it must be 0, for it depends on a body that keeps its shape: set it to 0, or take sheet_law()");
  };
  absent("aspect_gain", law.aspect_gain);
  absent("recovery", law.recovery);
  absent("shelter", law.shelter);
  absent("curvature", law.curvature);
  const auto holds_back = [&](const char* name, const Law::Polynomial& p) {
    require(never_negative(p), named(name), Eigen::Map<const Eigen::Vector<double, 5>>(p.data()),
            "no Bernstein coefficient may be negative: pressure that pushes upwind would feed energy to the mesh");
  };
  holds_back("windward", law.windward);
  holds_back("leeward", law.leeward);
}

DeformingLaw deforming_law(const Law& law, bool two_sided, const Medium& medium) {
  check_law(law);
  require(medium.density >= 0.0 && medium.density < 1e100, "DeformingMesh: density", medium.density,
          "it must be finite and not negative [kg/m^3]");
  require(medium.viscosity == 0.0, "DeformingMesh: viscosity", medium.viscosity,
          "it must be 0: what viscosity does depends on a body that keeps its shape, and cloth has the law's constant friction instead");
  return {BodyLaw(law, {}, 0.0, ActiveEffects({}, {}, law, {})), two_sided, medium.density};
}

void check_count(const char* name, std::size_t found, std::size_t vertices) {
  require(
      found == vertices, [name] { return std::string("DeformingMesh: number of entries of ") + name; }, found,
      [vertices] { return "the mesh has " + std::to_string(vertices) + " vertices"; });
}

template <class Number>
void check_array(const char* name, const VertexArray<Number>& array, std::size_t vertices) {
  check_count(name, array.count, vertices);
  require(
      array.stride >= 3, [name] { return std::string("DeformingMesh: stride of ") + name; }, array.stride, "a vertex has three numbers");
  if (vertices > 0 && !array.first) throw std::invalid_argument(std::string("DeformingMesh: ") + name + " is null");
}

/// @param position, flow  of a vertex
template <class Position, class Flow>
std::vector<Vector3d> scatter(std::span<const Eigen::Vector3i> triangles, std::size_t vertices, const DeformingLaw& law,
                              const Position& position, const Flow& flow) {
  std::vector<Vector3d> sum(vertices, Vector3d::Zero());
  for (const Eigen::Vector3i& triangle : triangles) {
    const auto a = static_cast<std::size_t>(triangle[0]), b = static_cast<std::size_t>(triangle[1]),
               c = static_cast<std::size_t>(triangle[2]);
    const Vector3d u = (flow(a) + flow(b) + flow(c)) / 3.0;
    const Vector3d force = law.corner_force(position(b) - position(a), position(c) - position(a), u);
    sum[a] += force, sum[b] += force, sum[c] += force;
  }
  return sum;
}

/// Why a force is not finite: an input that some triangle meets, or the sizes.
[[noreturn]] void explain(std::span<const Eigen::Vector3i> triangles, VertexArray<const float> position, VertexArray<const float> velocity,
                          VertexArray<const float> wind) {
  for (const Eigen::Vector3i& triangle : triangles)
    for (const int corner : triangle) {
      const auto vertex = static_cast<std::size_t>(corner);
      const auto check = [&](const char* name, const Eigen::Vector3f& found) {
        require_finite([&] { return std::string("DeformingMesh: ") + name + " of vertex " + std::to_string(vertex); },
                       Vector3d(found.cast<double>()));
      };
      check("position", position[vertex]);
      check("velocity", velocity[vertex]);
      check("wind", wind[vertex]);
    }
  throw std::overflow_error(
      "DeformingMesh: a force is beyond 1e30 N, although every input is finite; velocity, density or size must be many orders of magnitude "
      "too large");
}

}  // namespace

DeformingMesh::DeformingMesh(std::span<const Eigen::Vector3i> triangles, std::size_t vertices, Surface::Sides sides)
    : triangles_(triangles.begin(), triangles.end()), vertices_(vertices), two_sided_(sides == Surface::Sides::two) {
  check_sides(sides);
  require(vertices < largest_mesh, "DeformingMesh: vertices", vertices, "it must be below 2^28");
  require(triangles_.size() < largest_mesh, "DeformingMesh: triangles", triangles_.size(), "it must be below 2^28");
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (const int corner : triangles_[t])
      require(
          corner >= 0 && static_cast<std::size_t>(corner) < vertices,
          [t] { return "DeformingMesh: vertex of triangle " + std::to_string(t); }, corner,
          [vertices] { return "it must be from 0 to " + std::to_string(vertices) + " - 1, the number of vertices less one"; });
  fast_ = fast_deforming(triangles_, vertices);
}
DeformingMesh::DeformingMesh(DeformingMesh&&) noexcept = default;
DeformingMesh& DeformingMesh::operator=(DeformingMesh&&) noexcept = default;
DeformingMesh::~DeformingMesh() = default;

void DeformingMesh::forces(VertexArray<const float> position, VertexArray<const float> velocity, const Vector3d& wind, const Medium& medium,
                           const Law& law, VertexArray<float> force) {
  const Eigen::Vector3f everywhere = wind.cast<float>();
  require(everywhere.allFinite(), "DeformingMesh: wind", wind, "it must be finite in single precision");
  // One vector that all vertices have: a stride of 0 is for this alone.
  sum_forces(position, velocity, {everywhere.data(), vertices_, 0}, medium, law, force);
}

void DeformingMesh::forces(VertexArray<const float> position, VertexArray<const float> velocity, VertexArray<const float> wind,
                           const Medium& medium, const Law& law, VertexArray<float> force) {
  check_array("wind", wind, vertices_);
  sum_forces(position, velocity, wind, medium, law, force);
}

void DeformingMesh::sum_forces(VertexArray<const float> position, VertexArray<const float> velocity, VertexArray<const float> wind,
                               const Medium& medium, const Law& law, VertexArray<float> force) {
  check_array("position", position, vertices_);
  check_array("velocity", velocity, vertices_);
  check_array("force", force, vertices_);
  const DeformingLaw felt = deforming_law(law, two_sided_, medium);
  if (fast_ && fast_->forces(position, velocity, wind, felt, force)) return;
  const auto at = [](const VertexArray<const float>& array) {
    return [&array](std::size_t vertex) { return Vector3d(array[vertex].template cast<double>()); };
  };
  const std::vector<Vector3d> sum = scatter(triangles_, vertices_, felt, at(position), [&](std::size_t vertex) {
    return Vector3d(wind[vertex].cast<double>() - velocity[vertex].cast<double>());
  });
  const bool usable =
      std::all_of(sum.begin(), sum.end(), [](const Vector3d& f) { return (f.array().abs() <= largest_deforming_force).all(); });
  if (!usable) explain(triangles_, position, velocity, wind);
  for (std::size_t vertex = 0; vertex < vertices_; ++vertex) force[vertex] = sum[vertex].cast<float>();
}

std::vector<Vector3d> reference::vertex_forces(std::span<const Eigen::Vector3i> triangles, Surface::Sides sides,
                                               std::span<const Vector3d> position, std::span<const Vector3d> velocity, const Vector3d& wind,
                                               const Medium& medium, const Law& law) {
  check_sides(sides);
  check_count("velocity", velocity.size(), position.size());
  return scatter(
      triangles, position.size(), deforming_law(law, sides == Surface::Sides::two, medium),
      [&](std::size_t vertex) { return position[vertex]; }, [&](std::size_t vertex) { return Vector3d(wind - velocity[vertex]); });
}

}  // namespace dragcore
