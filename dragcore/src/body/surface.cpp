#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <dragcore/surface.hpp>
#include <functional>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "body/convexity.hpp"
#include "body/creeping.hpp"
#include "body/edges.hpp"
#include "body/extents.hpp"
#include "body/pack.hpp"
#include "body/regions.hpp"
#include "support/triangle_second_moment.hpp"


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

// Facets that stand for one smooth piece of surface meet at less than this. Where exactly the line is drawn hardly matters: beyond 45
// degrees a region's weights are below 0.05.
constexpr double sharp_angle = 60.0 * std::numbers::pi / 180.0;

using Segment = std::pair<Vector3d, Vector3d>;

/// Joins the boundary segments of a patch that continue each other in a straight line, so that an outline has corners only.
std::vector<Segment> straightened(const std::vector<std::pair<int, int>>& boundary, const std::vector<Vector3d>& vertices) {
  const auto as_it_is = [&] {
    std::vector<Segment> outline;
    outline.reserve(boundary.size());
    for (const auto& [from, to] : boundary) outline.emplace_back(vertices[from], vertices[to]);
    return outline;
  };
  if (boundary.size() == 3) return as_it_is();  // a triangle: of a fine round mesh nearly every patch
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
  if (outline.size() < 3) return as_it_is();  // of a needle of 1 : 1e9 and more nothing would be left
  return outline;
}

/// Class of a part by thickness, and by how much of its area curves in every direction: both are free of scale and, once a round body has
/// eight facets around, of the triangulation.
BodyClass classify(const Surface& surface, const Part& p, const std::vector<Eigen::Index>& members) {
  if (!(p.volume > 0.0) || members.empty()) return BodyClass::sheet;
  const Vector3d extents = principal_box(static_cast<Eigen::Index>(members.size()), [&](Eigen::Index k) -> std::array<Vector3d, 3> {
                             const Eigen::Index i = members[static_cast<std::size_t>(k)];
                             const Vector3d ab = surface.edge_ab.row(i).matrix(), ac = surface.edge_ac.row(i).matrix();
                             const Vector3d a = surface.centroid.row(i).matrix().transpose() - (ab + ac) / 3.0;
                             return {a, a + ab, a + ac};
                           }).extents;
  if (is_sheet(p.volume, p.area, extents)) return BodyClass::sheet;
  // The smaller of the two principal curvatures, in units of the body: 2 on a ball, 0 on flat faces,
  // cylinders and cones. Of a teardrop 0.8 of the area passes, of a cone 0.02.
  double round = 0.0;
  for (const Eigen::Index i : members) {
    const Matrix3d k = symmetric(surface.curvature.row(i));
    const double mean = 0.5 * k.trace(), square = k.squaredNorm();  // one eigenvalue is 0, along the normal
    const double least = mean - std::sqrt(std::max(0.0, 0.5 * square - mean * mean));
    const double x = std::max(0.0, least) * std::sqrt(p.area / std::numbers::pi);
    round += surface.area[i] * x * x / (x * x + 0.005);
  }
  return round > 0.5 * p.area ? BodyClass::smooth : BodyClass::sharp;
}

/// Whether a triangle's winding runs along an edge in this direction.
bool runs(const Vector3i& t, int from, int to) {
  return (t[0] == from && t[1] == to) || (t[1] == from && t[2] == to) || (t[2] == from && t[0] == to);
}

}  // namespace

Surface::Surface(const TriangleMesh& mesh, Sides asked) {
  if (asked == Sides::automatic) {
    build(prepare(mesh));
    packed = kernels::pack(*this);
    return;
  }
  const MeshProperties found = inspect(mesh);
  if (asked == Sides::one && found.inside_out && found.volume < -1e-12 * found.area * std::sqrt(found.area))
    throw std::invalid_argument("surface: the mesh is inside out (volume " + std::to_string(found.volume) +
                                " m^3, normals must point into the air); reverse the winding of its triangles, or leave it to prepare()");
  if (asked == Sides::one && !found.consistently_wound)
    throw std::invalid_argument(
        "surface: neighbouring triangles are wound in opposite directions at " + std::to_string(found.inconsistent_edges) +
        " edges, so that outside is not defined; repair the winding by prepare(), or treat the mesh as a two-sided sheet");
  Preparation as_given{.mesh = welded(mesh)};
  as_given.part.assign(as_given.mesh.triangles.size(), 0);
  as_given.lid.assign(as_given.mesh.triangles.size(), false);
  as_given.sheet = {asked == Sides::two};
  build(as_given);
  // Told to be a body, its holes count as capped flat.
  if (asked == Sides::one) {
    volume = found.volume > 1e-9 * std::pow(found.area, 1.5) ? found.volume : 0.0;
    parts[0].volume = volume;
    find_classes();
  }
  packed = kernels::pack(*this);
}

Surface::Surface(const Preparation& preparation) {
  build(preparation);
  packed = kernels::pack(*this);
}

void Surface::build(const Preparation& preparation) {
  report = preparation.report;
  exposed = preparation.exposed;
  const std::vector<Vector3d>& vertices = preparation.mesh.vertices;
  std::vector<Vector3i> triangles;
  std::vector<Eigen::Index> source;  // of every triangle that is kept
  for (std::size_t i = 0; i < preparation.mesh.triangles.size(); ++i) {
    const Vector3i& t = preparation.mesh.triangles[i];
    if (is_degenerate(vertices[t[0]], vertices[t[1]], vertices[t[2]])) continue;
    triangles.push_back(t);
    source.push_back(static_cast<Eigen::Index>(i));
  }

  const auto count = static_cast<Eigen::Index>(triangles.size());
  for (Eigen::ArrayX3d* column : {&normal, &centroid, &edge_ab, &edge_ac}) column->resize(count, 3);
  area.resize(count);
  back.resize(count);
  part.resize(static_cast<std::size_t>(count));
  parts.resize(std::max<std::size_t>(1, preparation.sheet.size()));
  for (std::size_t p = 0; p < preparation.sheet.size(); ++p) parts[p].two_sided = preparation.sheet[p];
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3i& t = triangles[static_cast<std::size_t>(i)];
    const Vector3d a = vertices[t[0]], ab = vertices[t[1]] - a, ac = vertices[t[2]] - a;
    const Vector3d cross = ab.cross(ac);
    normal.row(i) = cross.stableNormalized().array();
    area[i] = 0.5 * cross.stableNorm();
    centroid.row(i) = (a + (ab + ac) / 3.0).array();
    edge_ab.row(i) = ab.array();
    edge_ac.row(i) = ac.array();
    part[static_cast<std::size_t>(i)] = preparation.part[static_cast<std::size_t>(source[static_cast<std::size_t>(i)])];
    back[i] = parts[static_cast<std::size_t>(part[static_cast<std::size_t>(i)])].two_sided ? 1.0 : 0.0;
  }
  const EdgeTable edges(triangles);
  convex = parts.size() == 1 && is_convex(triangles, vertices, parts[0].two_sided, &edges);

  // Of a triangle that is covered in part the rest is taken as a smaller one of its shape, in the middle of that rest.
  if (!preparation.wetted.empty())
    for (Eigen::Index i = 0; i < count; ++i) {
      const WettedPiece& piece = preparation.wetted[static_cast<std::size_t>(source[static_cast<std::size_t>(i)])];
      const double rear = back[i] * piece.back;
      if (piece.front >= 1.0 && rear >= back[i]) continue;
      const double share = std::max(piece.front, rear);
      if (rear > piece.front) {  // the side with more of it counts as the front
        normal.row(i) = -normal.row(i);
        edge_ab.row(i).swap(edge_ac.row(i));
        std::swap(triangles[static_cast<std::size_t>(i)][1], triangles[static_cast<std::size_t>(i)][2]);
      }
      back[i] = share > 0.0 ? std::min(piece.front, rear) / share : 0.0;
      area[i] *= share;
      edge_ab.row(i) *= std::sqrt(share);
      edge_ac.row(i) *= std::sqrt(share);
      centroid.row(i) = piece.centroid.array();
    }
  if (preparation.exposure) {
    exposure = preparation.exposure;
    if (source.size() < preparation.mesh.triangles.size()) {
      auto kept = std::make_shared<Exposure>(*preparation.exposure);
      for (std::size_t i = 0; i < source.size(); ++i) kept->row[i] = preparation.exposure->row[static_cast<std::size_t>(source[i])];
      kept->row.resize(source.size());
      exposure = std::move(kept);
    }
  }

  find_patches(triangles, vertices, edges);
  find_parts();
  find_creeping_resistance();
  find_regions(triangles, edges);
  find_classes();
  find_shape_moments();
  const bool some_two = std::any_of(parts.begin(), parts.end(), [](const Part& p) { return p.two_sided; });
  const bool some_one = std::any_of(parts.begin(), parts.end(), [](const Part& p) { return !p.two_sided; });
  sides = count == 0 ? Sides::one : some_two && some_one ? Sides::automatic : some_two ? Sides::two : Sides::one;
}

void Surface::find_classes() {
  std::vector<std::vector<Eigen::Index>> members(parts.size());
  for (Eigen::Index i = 0; i < size(); ++i) members[static_cast<std::size_t>(part[static_cast<std::size_t>(i)])].push_back(i);
  for (std::size_t p = 0; p < parts.size(); ++p) parts[p].body_class = classify(*this, parts[p], members[p]);
  body_class = std::max_element(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.area < b.area; })->body_class;
}

/// Floods each patch from its first triangle. A sheet has no outside: its triangles may be wound either way, `turn` is -1 where it is
/// against the first's.
void Surface::find_patches(const std::vector<Vector3i>& triangles, const std::vector<Vector3d>& vertices, const EdgeTable& edges) {
  const Eigen::Index count = size();
  patch.assign(static_cast<std::size_t>(count), -1);
  std::vector<int> turn(static_cast<std::size_t>(count), 1), members;
  std::vector<std::array<int, 3>> directed;  // edges, lower end first, and which way they are run through
  std::vector<std::pair<int, int>> boundary;
  for (Eigen::Index first = 0; first < count; ++first) {
    if (patch[static_cast<std::size_t>(first)] >= 0) continue;
    const int id = static_cast<int>(patches.size());
    const Vector3d plane = normal.row(first).matrix();
    members = {static_cast<int>(first)};
    patch[static_cast<std::size_t>(first)] = id;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const Vector3i& t = triangles[static_cast<std::size_t>(members[k])];
      for (std::size_t e = 0; e < 3; ++e)
        for (const EdgeUse& use : edges.at(static_cast<std::size_t>(members[k]), e)) {
          const int other = use.triangle;
          if (patch[static_cast<std::size_t>(other)] >= 0) continue;
          const Vector3d next = normal.row(other).matrix();
          if (plane.cross(next).norm() >= coplanar_angle) continue;
          const int side = plane.dot(next) > 0.0 ? 1 : -1;
          const auto from = static_cast<Eigen::Index>(e);
          if (side != turn[static_cast<std::size_t>(members[k])] &&
              !(back[other] > 0.0 && runs(triangles[static_cast<std::size_t>(other)], t[from], t[(from + 1) % 3])))
            continue;
          patch[static_cast<std::size_t>(other)] = id;
          turn[static_cast<std::size_t>(other)] = side;
          members.push_back(other);
        }
    }

    Patch p{.part = part[static_cast<std::size_t>(first)]};
    Vector3d area_vector = Vector3d::Zero(), moment = Vector3d::Zero();
    directed.clear();
    for (const int i : members) {
      const auto t = static_cast<std::size_t>(i);
      p.area += area[i];
      area_vector += turn[t] * area[i] * normal.row(i).matrix().transpose();
      moment += area[i] * centroid.row(i).matrix().transpose();
      for (int e = 0; e < 3; ++e) {
        const int from = triangles[t][e], to = triangles[t][(e + 1) % 3];
        directed.push_back({std::min(from, to), std::max(from, to), (from < to ? 1 : -1) * turn[t]});
      }
    }
    // Edges minus their reverses: what is left is the boundary, repeated where triangles are.
    std::sort(directed.begin(), directed.end());
    boundary.clear();
    for (std::size_t k = 0; k < directed.size();) {
      const int low = directed[k][0], high = directed[k][1];
      int times = 0;
      for (; k < directed.size() && directed[k][0] == low && directed[k][1] == high; ++k) times += directed[k][2];
      for (int n = 0; n < std::abs(times); ++n) boundary.emplace_back(times > 0 ? low : high, times > 0 ? high : low);
    }
    p.normal = area_vector.stableNormalized();
    p.centroid = p.area > 0.0 ? Vector3d(moment / p.area) : Vector3d(centroid.row(first).matrix().transpose());
    if (p.area > 0.0)
      for (const int i : members) {
        // Second moment of a triangle about the patch's centroid: three midpoints of edges are exact to degree 2.
        const Vector3d a = (centroid.row(i) - (edge_ab.row(i) + edge_ac.row(i)) / 3.0).matrix(), ab = edge_ab.row(i).matrix(),
                       ac = edge_ac.row(i).matrix();
        for (const Vector3d& midpoint : {Vector3d(a + 0.5 * ab), Vector3d(a + 0.5 * ac), Vector3d(a + 0.5 * (ab + ac))})
          p.second_moment += area[i] / (3.0 * p.area) * (midpoint - p.centroid) * (midpoint - p.centroid).transpose();
      }
    std::sort(boundary.begin(), boundary.end());
    p.outline = straightened(boundary, vertices);
    patches.push_back(std::move(p));
  }
}

/// Area, volume, centre and radius of the parts and of all. Volumes by the divergence theorem, about a point of the part: a body far away
/// must not lose digits. It holds of triangles that are covered in part, too: what is left of them is the boundary of all bodies together.
void Surface::find_parts() {
  const Eigen::Index count = size();
  total_area = area.sum();
  if (count > 0) centre = ((centroid.colwise() * area).colwise().sum() / std::max(total_area, 1e-300)).matrix();
  for (Eigen::Index i = 0; i < count; ++i) {
    Part& p = parts[static_cast<std::size_t>(part[static_cast<std::size_t>(i)])];
    p.area += area[i];
    p.centre += area[i] * centroid.row(i).matrix().transpose();
  }
  for (Part& p : parts)
    if (p.area > 0.0) p.centre /= p.area;
  for (Eigen::Index i = 0; i < count; ++i) {
    Part& p = parts[static_cast<std::size_t>(part[static_cast<std::size_t>(i)])];
    if (!p.two_sided) p.volume += area[i] * normal.row(i).matrix().dot((centroid.row(i).matrix().transpose() - p.centre)) / 3.0;
    const Vector3d a = (centroid.row(i) - (edge_ab.row(i) + edge_ac.row(i)) / 3.0).matrix();
    for (const Vector3d& corner :
         {a, Vector3d(a + edge_ab.row(i).matrix().transpose()), Vector3d(a + edge_ac.row(i).matrix().transpose())}) {
      p.radius = std::max(p.radius, (corner - p.centre).norm());
      radius = std::max(radius, (corner - centre).norm());
    }
  }
  for (Part& p : parts) {
    if (!(p.volume > 1e-9 * std::pow(p.area, 1.5))) p.volume = 0.0;
    volume += p.volume;
  }
}

/// First and second moments of the wetted area, about a point of the part.
void Surface::find_creeping_resistance() {
  std::vector<Vector3d> first(parts.size(), Vector3d::Zero());
  std::vector<Matrix3d> second(parts.size(), Matrix3d::Zero());
  for (Eigen::Index i = 0; i < size(); ++i) {
    const auto p = static_cast<std::size_t>(part[static_cast<std::size_t>(i)]);
    const double wetted = area[i] * (1.0 + back[i]);
    const Vector3d arm = centroid.row(i).matrix().transpose() - parts[p].centre;
    parts[p].creeping.wetted += wetted;
    first[p] += wetted * arm;
    second[p] += wetted * (arm * arm.transpose() +
                           triangle_second_moment(Vector3d(edge_ab.row(i).matrix()), Vector3d(edge_ac.row(i).matrix())));
  }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    CreepingResistance& creeping = parts[p].creeping;
    if (!(creeping.wetted > 0.0)) continue;
    const Vector3d off = first[p] / creeping.wetted;
    creeping.centre = parts[p].centre + off;
    dragcore::find_creeping_resistance(second[p] / creeping.wetted - off * off.transpose(), creeping);
  }
}

void Surface::find_shape_moments() {
  shape_moments = {};
  if (!(total_area > 0.0) || !(radius > 0.0)) return;
  for (Eigen::Index i = 0; i < size(); ++i) {
    const Vector3d ab = edge_ab.row(i).matrix() / radius, ac = edge_ac.row(i).matrix() / radius;
    const Vector3d middle = (centroid.row(i).matrix().transpose() - centre) / radius;
    const std::array corners{Vector3d(middle - (ab + ac) / 3.0), Vector3d(middle + (2.0 * ab - ac) / 3.0),
                             Vector3d(middle + (2.0 * ac - ab) / 3.0)};
    const double share = area[i] / total_area;
    // Exact to degree 3: the centroid, the middles of the edges and the corners, 27, 8 and 3 sixtieths.
    const auto add = [&](const Vector3d& r, double weight) {
      std::size_t k = 0;
      for (Eigen::Index a = 0; a < 3; ++a)
        for (Eigen::Index b = a; b < 3; ++b) shape_moments[k++] += weight * r[a] * r[b];
      for (Eigen::Index a = 0; a < 3; ++a)
        for (Eigen::Index b = a; b < 3; ++b)
          for (Eigen::Index c = b; c < 3; ++c) shape_moments[k++] += weight * r[a] * r[b] * r[c];
    };
    add(middle, share * 27.0 / 60.0);
    for (std::size_t k = 0; k < 3; ++k) {
      add(corners[k], share * 3.0 / 60.0);
      add(0.5 * (corners[k] + corners[(k + 1) % 3]), share * 8.0 / 60.0);
    }
  }
  shape_moments.back() = volume / (total_area * radius);
}

/// Smooth components, and of every triangle the region around it.
void Surface::find_regions(const std::vector<Vector3i>& triangles, const EdgeTable& edges) {
  const auto count = static_cast<std::size_t>(size());
  DisjointSets components(count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t e = 0; e < 3; ++e) {
      const Vector3i& t = triangles[i];
      const auto k = static_cast<Eigen::Index>(e);
      for (const EdgeUse& use : edges.at(i, e)) {
        const int other = use.triangle;
        if (other <= static_cast<int>(i)) continue;
        double cosine = normal.row(static_cast<Eigen::Index>(i)).matrix().dot(normal.row(other).matrix());
        if (back[other] > 0.0 && runs(triangles[static_cast<std::size_t>(other)], t[k], t[(k + 1) % 3]))
          cosine = -cosine;  // wound against this one
        if (cosine > std::cos(sharp_angle)) components.join(static_cast<int>(i), other);
      }
    }
  int number = 0;
  const std::vector<int> component = components.labels(number);
  std::vector<int> by_component(count);
  std::iota(by_component.begin(), by_component.end(), 0);
  sort_by_buckets(
      by_component, static_cast<std::size_t>(number), [&](int i) { return component[static_cast<std::size_t>(i)]; }, std::less<>());
  second_moment.setZero(size(), 6);
  curvature.setZero(size(), 6);
  const auto row_of = [](const Matrix3d& m) {
    return (Eigen::Array<double, 1, 6>() << m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)).finished();
  };
  std::vector<RegionFacet> facets;
  for (std::size_t first = 0; first < count;) {
    facets.clear();
    const auto at = static_cast<std::size_t>(by_component[first]);
    for (std::size_t k = first; k < count && component[static_cast<std::size_t>(by_component[k])] == component[at]; ++k) {
      const int i = by_component[k];
      facets.push_back({normal.row(i).matrix(), centroid.row(i).matrix(), edge_ab.row(i).matrix(), edge_ac.row(i).matrix(), area[i]});
    }
    const Part& owner = parts[static_cast<std::size_t>(part[at])];
    dragcore::find_regions(facets, owner.two_sided, 1e-3 * owner.radius, [&](std::size_t k, const Region& region) {
      const int i = by_component[first + k];
      second_moment.row(i) = row_of(region.second_moment);
      curvature.row(i) = row_of(region.curvature);
    });
    first += facets.size();
  }
}

}  // namespace dragcore
