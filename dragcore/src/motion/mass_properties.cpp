#include <Eigen/Geometry>
#include <cmath>
#include <dragcore/mass_properties.hpp>

#include "support/require.hpp"

namespace dragcore {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void require_density(const std::string& what, double found) {
  require(found > 0.0 && std::isfinite(found), what, found, "it must be finite and greater than 0");
}

/// Sums of r^0, r^1 and r^2 over the corners' tetrahedra or triangles, from a point of the mesh, so that a body far away loses no digits.
struct Moments {
  double content = 0.0;                // volume or area
  Vector3d first = Vector3d::Zero();   // integral of r
  Matrix3d second = Matrix3d::Zero();  // integral of r r^T

  /// A simplex of n + 1 corners in n dimensions, whose barycentric coordinates b have the means 1/(n + 1) of b_i and
  /// (1 + delta_ij) / ((n + 1)(n + 2)) of b_i b_j. A corner at the origin adds nothing to the sums.
  void add(int n, double size, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const Vector3d sum = a + b + c;
    content += size;
    first += size / (n + 1) * sum;
    second += size / ((n + 1) * (n + 2)) * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }

  MeshMass times(double density, const Vector3d& origin) const {
    const Vector3d centre = first / content;
    const Matrix3d central = density * (second - content * centre * centre.transpose());
    MeshMass result;
    result.mass = density * content;
    result.inertia = central.trace() * Matrix3d::Identity() - central;
    result.centre_of_mass = origin + centre;
    if (!(result.mass > 0.0) || !std::isfinite(result.mass) || !result.inertia.allFinite() || !result.centre_of_mass.allFinite())
      throw std::overflow_error("mass properties: mass or inertia is beyond the range of numbers, 1e-308 to 1e308");
    return result;
  }
};

template <class Visit>
Vector3d for_each_triangle(const TriangleMesh& mesh, Visit&& visit) {
  const Vector3d origin = mesh.vertices[static_cast<std::size_t>(mesh.triangles.front()[0])];
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int k) -> Vector3d { return mesh.vertices[static_cast<std::size_t>(t[k])] - origin; };
    visit(corner(0), corner(1), corner(2));
  }
  return origin;
}

}  // namespace

MeshMass mass_properties(const TriangleMesh& mesh, double density) {
  require_density("mass_properties: density", density);
  const MeshProperties found = inspect(mesh);
  const std::string what = "mass_properties: mesh";
  require(found.triangles > 0, what, "no triangles", "a solid needs a closed mesh");
  // Holes without boundary edges: edges of three or more triangles whose windings do not balance.
  require(found.boundary_edges == 0 && found.hole_area <= 1e-12 * found.area, what + ": open or unmatched edges",
          found.boundary_edges > 0 ? found.boundary_edges : found.non_manifold_edges,
          "a solid needs a closed mesh: close the holes, or take sheet_mass_properties() for a skin");
  require(found.consistently_wound, what + ": edges of inconsistent winding", found.inconsistent_edges,
          "a solid needs all triangles counterclockwise from outside: turn those that are not");
  // 1e-12 of the volume of a ball of the same area: what is less is rounding.
  require(std::abs(found.volume) > 1e-12 * 0.094 * std::pow(found.area, 1.5), what + ": volume", found.volume,
          "a solid needs some: take sheet_mass_properties() for a skin");
  require(found.volume > 0.0, what + ": volume", found.volume,
          "it must be positive: the mesh is inside out, swap two corners of every triangle");
  Moments moments;
  const Vector3d origin = for_each_triangle(
      mesh, [&](const Vector3d& a, const Vector3d& b, const Vector3d& c) { moments.add(3, a.dot(b.cross(c)) / 6.0, a, b, c); });
  return moments.times(density, origin);
}

MeshMass sheet_mass_properties(const TriangleMesh& mesh, double area_density) {
  require_density("sheet_mass_properties: area_density", area_density);
  validate(mesh);
  require(!mesh.triangles.empty(), "sheet_mass_properties: mesh", "no triangles", "it must have some");
  Moments moments;
  const Vector3d origin = for_each_triangle(
      mesh, [&](const Vector3d& a, const Vector3d& b, const Vector3d& c) { moments.add(2, 0.5 * (b - a).cross(c - a).norm(), a, b, c); });
  require(moments.content > 0.0, "sheet_mass_properties: area of the mesh", moments.content, "it must be greater than 0");
  return moments.times(area_density, origin);
}

TriangleMesh recentred(const TriangleMesh& mesh, const Vector3d& origin) {
  require_finite("recentred: origin", origin);
  return transformed(mesh, Matrix3d::Identity(), -origin);
}

TriangleMesh recentred(const TriangleMesh& mesh) { return recentred(mesh, inspect(mesh).centroid); }

}  // namespace dragcore
