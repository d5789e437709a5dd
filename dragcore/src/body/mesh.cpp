#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <dragcore/mesh.hpp>
#include <numeric>
#include <sstream>
#include <stdexcept>

namespace dragcore {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

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

/// An edge of the boundary, and how much oftener it is run through from its lower vertex to its higher one than backwards.
struct BoundaryEdge {
  int low, high, times;
};

/// The boundary as connected loops, in the order of their roots.
std::vector<Hole> holes(const std::vector<BoundaryEdge>& boundary, const std::vector<Vector3d>& vertices, const Vector3d& origin) {
  // Vertices of the boundary by their place in this list.
  std::vector<int> corners;
  for (const BoundaryEdge& edge : boundary) corners.insert(corners.end(), {edge.low, edge.high});
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  const auto place = [&](int v) { return static_cast<std::size_t>(std::lower_bound(corners.begin(), corners.end(), v) - corners.begin()); };
  std::vector<std::size_t> parent(corners.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&parent](std::size_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const BoundaryEdge& edge : boundary) parent[root(place(edge.low))] = root(place(edge.high));
  std::vector<Hole> by_root(corners.size());
  for (const BoundaryEdge& edge : boundary) {
    Hole& hole = by_root[root(place(edge.low))];
    const Vector3d from = vertices[static_cast<std::size_t>(edge.low)] - origin,
                   to = vertices[static_cast<std::size_t>(edge.high)] - origin;
    hole.area += 0.5 * edge.times * from.cross(to);
    hole.centre += 0.5 * (from + to);
    ++hole.edges;
  }
  std::erase_if(by_root, [](const Hole& hole) { return hole.edges == 0; });
  for (Hole& hole : by_root) hole.centre /= hole.edges;
  return by_root;
}

/// A triangle's directed edge as one number that sorts by lower vertex, higher vertex, direction.
std::uint64_t edge_key(int from, int to) {
  const auto [low, high] = std::minmax(from, to);
  return static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high) << 1 | static_cast<std::uint64_t>(from > to);
}

/// Vertices of a mesh by their place, found in a time that does not grow with their number. Holds indices into `vertices`.
class PlaceIndex {
 public:
  PlaceIndex(const std::vector<Vector3d>& vertices, std::size_t most) : vertices_(vertices), slots_(std::bit_ceil(2 * most + 1), -1) {}

  /// The index of the vertex at `v`, or `if_new` after taking that down. Zeros must have no sign.
  int find_or_add(const Vector3d& v, int if_new) {
    std::uint64_t hash = 0;
    for (const double x : v) {  // every bit of the three decides, and the lowest ones of the result depend on all
      hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t slot = hash & mask;; slot = (slot + 1) & mask) {
      if (slots_[slot] < 0) return slots_[slot] = if_new;
      if (vertices_[static_cast<std::size_t>(slots_[slot])] == v) return slots_[slot];
    }
  }

 private:
  const std::vector<Vector3d>& vertices_;
  std::vector<int> slots_;
};

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
  PlaceIndex index(result.vertices, mesh.vertices.size());
  std::vector<int> renumbered(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d v = mesh.vertices[i] + Vector3d::Zero();  // turns -0.0 into 0.0, the same place
    const auto next = static_cast<int>(result.vertices.size());
    renumbered[i] = index.find_or_add(v, next);
    if (renumbered[i] == next) result.vertices.push_back(v);
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

  std::vector<std::uint64_t> edges;
  edges.reserve(3 * joined.triangles.size());
  std::vector<std::array<int, 3>> corners;  // of each triangle, in rising order
  corners.reserve(joined.triangles.size());
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
    corners.push_back(sorted);
    p.area += area;
    area_moment += area * (a + b + c) / 3.0;
    const double tetrahedron = a.dot(b.cross(c)) / 6.0;
    p.volume += tetrahedron;
    volume_moment += tetrahedron * (a + b + c) / 4.0;
    if (repeated_vertex) continue;  // it has no edges of its own
    for (int k = 0; k < 3; ++k) edges.push_back(edge_key(t[k], t[(k + 1) % 3]));
  }
  std::sort(corners.begin(), corners.end());
  for (std::size_t i = 1; i < corners.size(); ++i)
    if (corners[i] == corners[i - 1]) ++p.duplicated;

  std::sort(edges.begin(), edges.end());
  std::vector<BoundaryEdge> boundary;  // edges that their triangles run through oftener one way than the other; bad winding makes no hole
  for (std::size_t i = 0; i < edges.size();) {
    const std::uint64_t edge = edges[i] >> 1;
    int forward = 0, total = 0;
    for (; i < edges.size() && edges[i] >> 1 == edge; ++i, ++total)
      if ((edges[i] & 1u) == 0) ++forward;
    const int backward = total - forward;
    if (total == 1) ++p.boundary_edges;
    if (total > 2) ++p.non_manifold_edges;
    if (total == 2 && forward != 1) ++p.inconsistent_edges;
    if (total != 2 && forward != backward)
      boundary.push_back({static_cast<int>(edge >> 31), static_cast<int>(edge & 0x7fffffffu), forward - backward});
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
