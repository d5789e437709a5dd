#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dragcore/surface.hpp>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace dragcore {

std::string to_string(BodyClass body_class) {
  switch (body_class) {
    case BodyClass::sheet:
      return "sheet";
    case BodyClass::sharp:
      return "sharp";
    case BodyClass::smooth:
      return "smooth";
  }
  throw std::invalid_argument("not a body class");
}

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3i;

// Neighbours belong to one patch when their normals agree to 1e-3 rad with the patch's first triangle: single-precision files jitter by
// 1e-6, while the facets of a round body of 100,000 triangles still differ by 1e-2.
constexpr double coplanar_angle = 1e-3;

// Facets that stand for a curved surface meet at small angles; a prism of eight sides still counts as round, one of six (60 degrees) as
// sharp.
constexpr double sharp_angle = 50.0 * std::numbers::pi / 180.0;

using Segment = std::pair<Vector3d, Vector3d>;

/// Joins the boundary segments of a patch that continue each other in a straight line, so that an outline has corners only.
std::vector<Segment> straightened(const std::vector<std::pair<int, int>>& boundary, const std::vector<Vector3d>& vertices) {
  std::map<int, std::vector<int>> next, previous;
  for (const auto& [from, to] : boundary) {
    next[from].push_back(to);
    previous[to].push_back(from);
  }
  const auto is_straight = [&](int v) {
    if (next[v].size() != 1 || previous[v].size() != 1) return false;
    const Vector3d in = (vertices[v] - vertices[previous[v][0]]).normalized(), out = (vertices[next[v][0]] - vertices[v]).normalized();
    return in.dot(out) > 0.0 && in.cross(out).norm() < 1e-9;
  };
  std::map<int, bool> straight;
  for (const auto& [from, to] : boundary) straight.try_emplace(from, is_straight(from));
  std::vector<Segment> outline;
  for (const auto& [from, to] : boundary) {
    if (straight[from]) continue;
    int end = to;
    while (straight[end]) end = next[end][0];
    outline.emplace_back(vertices[from], vertices[end]);
  }
  if (outline.size() < 3) {  // of a needle of 1 : 1e9 and more nothing would be left
    outline.clear();
    for (const auto& [from, to] : boundary) outline.emplace_back(vertices[from], vertices[to]);
  }
  return outline;
}

/// Class of a body by thickness and by how much of its turning is done by sharp edges: both are free of scale and, once a round body has
/// eight facets around, of the triangulation.
BodyClass classify(const Surface& surface, double sharp_turning, double smooth_turning) {
  if (!(surface.volume > 0.0) || surface.size() == 0) return BodyClass::sheet;
  Matrix3d moment = Matrix3d::Zero();
  for (const Patch& patch : surface.patches) {
    const Vector3d arm = patch.centroid - surface.centre;
    moment += patch.area * (patch.second_moment + arm * arm.transpose());
  }
  const Matrix3d axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(moment / surface.total_area).eigenvectors();
  Vector3d lowest = Vector3d::Zero(), highest = Vector3d::Zero();
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Vector3d a = (surface.centroid.row(i) - (surface.edge_ab.row(i) + surface.edge_ac.row(i)) / 3.0).matrix();
    for (const Vector3d& corner :
         {a, Vector3d(a + surface.edge_ab.row(i).matrix().transpose()), Vector3d(a + surface.edge_ac.row(i).matrix().transpose())}) {
      const Vector3d place = axes.transpose() * (corner - surface.centre);
      lowest = lowest.cwiseMin(place);
      highest = highest.cwiseMax(place);
    }
  }
  Vector3d extent = highest - lowest;
  std::sort(extent.begin(), extent.end());
  // Mean thickness 2 V/A: a twentieth of the chord for the plates and discs that the sheet law was fitted to, a quarter of the width for a
  // box of half depth.
  if (2.0 * surface.volume / surface.total_area < 0.12 * extent[1]) return BodyClass::sheet;
  // Sharp edges do 0.55 of the turning of a cone of 60 degrees, 0.44 of a cylinder twice as long as wide, none of a ball's.
  return sharp_turning < 0.25 * (sharp_turning + smooth_turning) ? BodyClass::smooth : BodyClass::sharp;
}

/// Whether a triangle's winding runs along an edge in this direction.
bool runs(const Vector3i& t, int from, int to) {
  return (t[0] == from && t[1] == to) || (t[1] == from && t[2] == to) || (t[2] == from && t[0] == to);
}

}  // namespace

Surface::Surface(const TriangleMesh& mesh, Sides asked) : sides(asked) {
  const MeshProperties found = inspect(mesh);
  if (asked == Sides::automatic) sides = found.encloses || found.triangles == 0 ? Sides::one : Sides::two;
  // A sheet has no outside, and two skins at one place no volume but rounding.
  if (sides == Sides::one && found.inside_out && found.volume < -1e-12 * found.area * std::sqrt(found.area))
    throw std::invalid_argument("surface: the mesh is inside out (volume " + std::to_string(found.volume) +
                                " m^3, normals must point into the air); reverse the winding of its triangles");
  if (sides == Sides::one && !found.consistently_wound)
    throw std::invalid_argument("surface: neighbouring triangles are wound in opposite directions at " +
                                std::to_string(found.inconsistent_edges) +
                                " edges, so that outside is not defined; repair the winding, or treat the mesh as a two-sided sheet");

  const TriangleMesh joined = welded(mesh);
  std::vector<Vector3i> triangles;
  for (const Vector3i& t : joined.triangles)
    if (!is_degenerate(joined.vertices[t[0]], joined.vertices[t[1]], joined.vertices[t[2]])) triangles.push_back(t);

  const auto count = static_cast<Eigen::Index>(triangles.size());
  for (Eigen::ArrayX3d* column : {&normal, &centroid, &edge_ab, &edge_ac}) column->resize(count, 3);
  area.resize(count);
  std::map<std::pair<int, int>, std::vector<int>> neighbours;  // by undirected edge
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3i& t = triangles[i];
    const Vector3d a = joined.vertices[t[0]], ab = joined.vertices[t[1]] - a, ac = joined.vertices[t[2]] - a;
    const Vector3d cross = ab.cross(ac);
    normal.row(i) = cross.stableNormalized().array();
    area[i] = 0.5 * cross.stableNorm();
    centroid.row(i) = (a + (ab + ac) / 3.0).array();
    edge_ab.row(i) = ab.array();
    edge_ac.row(i) = ac.array();
    for (int k = 0; k < 3; ++k) neighbours[std::minmax(t[k], t[(k + 1) % 3])].push_back(static_cast<int>(i));
  }

  // Flood each patch from its first triangle. A sheet has no outside: its triangles may be wound either way, `turn` is -1 where it is
  // against the first's.
  patch.assign(count, -1);
  std::vector<int> turn(count, 1);
  for (Eigen::Index first = 0; first < count; ++first) {
    if (patch[first] >= 0) continue;
    const int id = static_cast<int>(patches.size());
    const Vector3d plane = normal.row(first).matrix();
    std::vector<int> members{static_cast<int>(first)};
    patch[first] = id;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const Vector3i& t = triangles[members[k]];
      for (int e = 0; e < 3; ++e)
        for (const int other : neighbours[std::minmax(t[e], t[(e + 1) % 3])]) {
          if (patch[other] >= 0 || plane.cross(Vector3d(normal.row(other).matrix())).norm() >= coplanar_angle) continue;
          const int side = plane.dot(normal.row(other).matrix()) > 0.0 ? 1 : -1;
          if (side != turn[members[k]] && !(two_sided() && runs(triangles[other], t[e], t[(e + 1) % 3]))) continue;
          patch[other] = id;
          turn[other] = side;
          members.push_back(other);
        }
    }

    Patch p;
    Vector3d area_vector = Vector3d::Zero(), moment = Vector3d::Zero();
    std::map<std::pair<int, int>, int> directed;  // edges minus their reverses: what is left is the boundary
    for (const int i : members) {
      p.area += area[i];
      area_vector += turn[i] * area[i] * normal.row(i).matrix().transpose();
      moment += area[i] * centroid.row(i).matrix().transpose();
      for (int e = 0; e < 3; ++e) {
        int from = triangles[i][e], to = triangles[i][(e + 1) % 3];
        if (turn[i] < 0) std::swap(from, to);
        if (const auto reverse = directed.find({to, from}); reverse == directed.end())
          ++directed[{from, to}];
        else if (--reverse->second == 0)
          directed.erase(reverse);
      }
    }
    p.normal = area_vector.stableNormalized();
    p.centroid = moment / p.area;
    for (const int i : members) {
      // Second moment of a triangle about the patch's centroid: three midpoints of edges are exact to degree 2.
      const Vector3d a = (centroid.row(i) - (edge_ab.row(i) + edge_ac.row(i)) / 3.0).matrix(), ab = edge_ab.row(i).matrix(),
                     ac = edge_ac.row(i).matrix();
      for (const Vector3d& midpoint : {Vector3d(a + 0.5 * ab), Vector3d(a + 0.5 * ac), Vector3d(a + 0.5 * (ab + ac))})
        p.second_moment += area[i] / (3.0 * p.area) * (midpoint - p.centroid) * (midpoint - p.centroid).transpose();
    }
    std::vector<std::pair<int, int>> boundary;
    for (const auto& [edge, times] : directed) boundary.insert(boundary.end(), times, edge);  // repeated where triangles are
    p.outline = straightened(boundary, joined.vertices);
    patches.push_back(std::move(p));
  }

  // Curvature from dihedral angles: an edge of length l that turns the normal by theta gives each of its triangles half of theta l, across
  // the edge.
  curvature.setZero(count, 6);
  double sharp_turning = 0.0, smooth_turning = 0.0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3i& t = triangles[i];
    const Vector3d n = normal.row(i).matrix();
    for (int e = 0; e < 3; ++e) {
      const std::vector<int>& pair = neighbours[std::minmax(t[e], t[(e + 1) % 3])];
      if (pair.size() != 2 || pair[0] == pair[1]) continue;
      const int neighbour = pair[0] == i ? pair[1] : pair[0];
      Vector3d other = normal.row(neighbour).matrix();
      if (two_sided() && runs(triangles[neighbour], t[e], t[(e + 1) % 3])) other = -other;  // wound against this one
      const Vector3d edge = joined.vertices[t[(e + 1) % 3]] - joined.vertices[t[e]];
      const double length = edge.norm(), theta = std::atan2(n.cross(other).dot(edge) / length, n.dot(other));
      (std::abs(theta) < sharp_angle ? smooth_turning : sharp_turning) += 0.5 * std::abs(theta) * length;
      if (std::abs(theta) >= sharp_angle) continue;
      const Vector3d across = n.cross(edge) / length;
      const double share = 0.5 * theta * length / area[i];
      const auto add = [&](int column, double value) { curvature(i, column) += share * value; };
      add(0, across.x() * across.x()), add(1, across.x() * across.y()), add(2, across.x() * across.z());
      add(3, across.y() * across.y()), add(4, across.y() * across.z()), add(5, across.z() * across.z());
    }
  }

  total_area = area.sum();
  if (sides == Sides::one && found.consistently_wound && found.volume > 1e-9 * std::pow(found.area, 1.5)) volume = found.volume;
  if (count > 0) centre = ((centroid.colwise() * area).colwise().sum() / total_area).matrix();
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3d a = (centroid.row(i) - (edge_ab.row(i) + edge_ac.row(i)) / 3.0).matrix();
    for (const Vector3d& corner : {a, Vector3d(a + edge_ab.row(i).matrix().transpose()), Vector3d(a + edge_ac.row(i).matrix().transpose())})
      radius = std::max(radius, (corner - centre).norm());
  }
  body_class = classify(*this, sharp_turning, smooth_turning);
}

}  // namespace dragcore
