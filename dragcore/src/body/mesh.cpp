#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <dragcore/mesh.hpp>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

namespace dragcore {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

using Point = std::array<double, 3>;

double extent(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0.0;
  Vector3d low = mesh.vertices.front(), high = low;
  for (const Vector3d& v : mesh.vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  return (high - low).norm();
}

/// A loop of the boundary: its area vector, as its triangles run along it, and a point in its middle.
struct Hole {
  Vector3d area = Vector3d::Zero(), centre = Vector3d::Zero();  // [m^2]; from `origin` [m]
  int edges = 0;
};

/// The boundary as connected loops. `boundary`: how much oftener each edge is run through forwards than backwards.
std::vector<Hole> holes(const std::map<std::pair<int, int>, int>& boundary, const std::vector<Vector3d>& vertices, const Vector3d& origin) {
  std::map<int, int> parent;
  const auto root = [&parent](int v) {
    while (parent.at(v) != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& [edge, times] : boundary) {
    parent.try_emplace(edge.first, edge.first), parent.try_emplace(edge.second, edge.second);
    parent[root(edge.first)] = root(edge.second);
  }
  std::map<int, Hole> by_root;
  for (const auto& [edge, times] : boundary) {
    Hole& hole = by_root[root(edge.first)];
    const Vector3d from = vertices[static_cast<std::size_t>(edge.first)] - origin,
                   to = vertices[static_cast<std::size_t>(edge.second)] - origin;
    hole.area += 0.5 * times * from.cross(to);
    hole.centre += 0.5 * (from + to);
    ++hole.edges;
  }
  std::vector<Hole> found;
  for (auto& [v, hole] : by_root) {
    hole.centre /= hole.edges;
    found.push_back(hole);
  }
  return found;
}

}  // namespace

bool is_degenerate(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  // Compared after dividing, so that edges of 1e-160 m do not underflow into a verdict.
  return !(longest > 0.0) || ((b - a) / longest).cross((c - a) / longest).norm() <= 2e-12;
}

void validate(const TriangleMesh& mesh) {
  const auto count = static_cast<int>(mesh.vertices.size());
  for (int i = 0; i < count; ++i)
    if (!mesh.vertices[i].allFinite()) {
      std::ostringstream message;
      message << "mesh: vertex " << i << " is (" << mesh.vertices[i].transpose()
              << "), but coordinates must be finite; repair or remove it";
      throw std::invalid_argument(message.str());
    }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int index : mesh.triangles[t])
      if (index < 0 || index >= count) {
        std::ostringstream message;
        message << "mesh: triangle " << t << " refers to vertex " << index << ", but there are " << count << " vertices (0 to " << count - 1
                << ")";
        throw std::invalid_argument(message.str());
      }
}

TriangleMesh welded(const TriangleMesh& mesh) {
  TriangleMesh result;
  std::map<Point, int> seen;
  std::vector<int> renumbered(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d v = mesh.vertices[i] + Vector3d::Zero();  // turns -0.0 into 0.0, the same place
    const auto [entry, added] = seen.try_emplace(Point{v.x(), v.y(), v.z()}, static_cast<int>(result.vertices.size()));
    if (added) result.vertices.push_back(v);
    renumbered[i] = entry->second;
  }
  result.triangles.reserve(mesh.triangles.size());
  for (const Vector3i& t : mesh.triangles) result.triangles.emplace_back(renumbered[t[0]], renumbered[t[1]], renumbered[t[2]]);
  return result;
}

MeshProperties inspect(const TriangleMesh& mesh) {
  validate(mesh);
  const TriangleMesh joined = welded(mesh);
  MeshProperties p;
  p.triangles = static_cast<int>(joined.triangles.size());
  const double size = extent(joined);

  struct EdgeUse {
    int forward = 0, backward = 0;
  };
  std::map<std::pair<int, int>, EdgeUse> edges;
  std::set<std::array<int, 3>> seen;
  // Moments about a point of the mesh, not the origin: a body far away must not lose digits.
  const Vector3d origin = joined.vertices.empty() ? Vector3d::Zero() : joined.vertices.front();
  Vector3d area_moment = Vector3d::Zero(), volume_moment = Vector3d::Zero();
  for (const Vector3i& t : joined.triangles) {
    const Vector3d a = joined.vertices[t[0]] - origin, b = joined.vertices[t[1]] - origin, c = joined.vertices[t[2]] - origin;
    const double area = 0.5 * (b - a).cross(c - a).norm();
    if (is_degenerate(a, b, c)) ++p.degenerate;
    const bool repeated_vertex = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    std::array<int, 3> sorted{t[0], t[1], t[2]};
    std::sort(sorted.begin(), sorted.end());
    if (!seen.insert(sorted).second) ++p.duplicated;
    p.area += area;
    area_moment += area * (a + b + c) / 3.0;
    const double tetrahedron = a.dot(b.cross(c)) / 6.0;
    p.volume += tetrahedron;
    volume_moment += tetrahedron * (a + b + c) / 4.0;
    if (repeated_vertex) continue;  // it has no edges of its own
    for (int k = 0; k < 3; ++k) {
      const int from = t[k], to = t[(k + 1) % 3];
      EdgeUse& use = edges[std::minmax(from, to)];
      ++(from < to ? use.forward : use.backward);
    }
  }
  std::map<std::pair<int, int>, int>
      boundary;  // edges that their triangles run through oftener one way than the other; bad winding makes no hole
  for (const auto& [edge, use] : edges) {
    const int total = use.forward + use.backward;
    if (total == 1) ++p.boundary_edges;
    if (total > 2) ++p.non_manifold_edges;
    if (total == 2 && use.forward != 1) ++p.inconsistent_edges;
    if (total != 2 && use.forward != use.backward) boundary[edge] = use.forward - use.backward;
  }
  for (const Hole& hole : holes(boundary, joined.vertices, origin)) {
    p.hole_area += hole.area.norm();
    p.volume -= hole.area.dot(hole.centre) / 3.0;
  }
  p.encloses = p.triangles > 0 && (p.boundary_edges == 0 || p.hole_area <= 0.05 * p.area);
  p.closed = p.triangles > 0 && p.boundary_edges == 0 && p.non_manifold_edges == 0;
  p.consistently_wound = p.inconsistent_edges == 0;
  p.inside_out = p.encloses && p.consistently_wound && p.volume < 0.0;
  if (p.closed && std::abs(p.volume) > 1e-12 * size * size * size)
    p.centroid = origin + volume_moment / p.volume;
  else if (p.area > 0.0)
    p.centroid = origin + area_moment / p.area;
  return p;
}

std::string describe(const MeshProperties& p) {
  if (p.triangles == 0) return "no triangles";
  std::ostringstream text;
  text << p.triangles << " triangles, ";
  if (p.closed)
    text << "closed";
  else if (p.encloses)
    text << "a body with holes of " << p.hole_area << " m^2";
  else
    text << "an open sheet (its boundary spans " << p.hole_area << " m^2: if walls of a body are missing, close them)";
  text << ", area " << p.area << " m^2";
  if (p.encloses) text << ", volume " << p.volume << " m^3";
  if (p.inside_out) text << "; inside out (normals point inwards)";
  if (!p.consistently_wound) text << "; winding inconsistent at " << p.inconsistent_edges << " edges";
  if (p.degenerate) text << "; " << p.degenerate << " degenerate triangles";
  if (p.duplicated) text << "; " << p.duplicated << " duplicated triangles";
  if (p.non_manifold_edges) text << "; " << p.non_manifold_edges << " edges shared by more than two triangles";
  return text.str();
}

TriangleMesh transformed(const TriangleMesh& mesh, const Eigen::Matrix3d& linear, const Vector3d& translation) {
  if (!linear.allFinite() || !translation.allFinite())
    throw std::invalid_argument("transformed: every entry of the transform must be finite");
  TriangleMesh result = mesh;
  for (Vector3d& v : result.vertices) v = linear * v + translation;
  if (linear.determinant() < 0.0)
    for (Vector3i& t : result.triangles) std::swap(t[1], t[2]);
  return result;
}

std::uint64_t surface_checksum(const TriangleMesh& mesh) {
  double largest = 0.0;
  for (const Vector3d& v : mesh.vertices) largest = std::max(largest, v.cwiseAbs().maxCoeff());
  const double unit = largest > 0.0 ? 1e-9 * largest : 1.0;
  std::uint64_t hash = 14695981039346656037ull;
  const auto mix = [&hash](std::int64_t value) {
    for (int byte = 0; byte < 8; ++byte) {
      hash ^= static_cast<std::uint64_t>(value >> (8 * byte)) & 0xffu;
      hash *= 1099511628211ull;
    }
  };
  mix(static_cast<std::int64_t>(mesh.vertices.size()));
  for (const Vector3d& v : mesh.vertices)
    for (const double x : v) mix(std::llround(x / unit));
  for (const Vector3i& t : mesh.triangles)
    for (const int index : t) mix(index);
  return hash;
}

}  // namespace dragcore
