#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <dragcore/expose.hpp>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <set>
#include <span>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "body/convexity.hpp"
#include "body/edges.hpp"
#include "exposure/direction_sphere.hpp"

namespace dragcore {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// Least c at which a ray leaves a side: nearer to edge-on the float's rounding decides what it meets.
constexpr double least_c = 0.05;

/// Gap below which two bodies touch, in half diagonals of the mesh's box: what modellers leave between parts that belong together.
constexpr double touching = 1e-3;

/// Embree's scene of a mesh, moved to the origin and scaled to half a diagonal of 1 before it becomes floats.
class Scene {
 public:
  explicit Scene(const TriangleMesh& mesh, int threads) {
    Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Vector3i& t : mesh.triangles)
      for (const int corner : t) {
        low = low.cwiseMin(mesh.vertices[static_cast<std::size_t>(corner)]);
        high = high.cwiseMax(mesh.vertices[static_cast<std::size_t>(corner)]);
      }
    centre_ = 0.5 * low + 0.5 * high;
    scale_ = 1.0 / std::max((0.5 * high - 0.5 * low).norm(), std::numeric_limits<double>::min());
    device_ = rtcNewDevice(("threads=" + std::to_string(threads)).c_str());
    if (!device_) throw std::runtime_error("expose: Embree does not start: error " + std::to_string(rtcGetDeviceError(nullptr)));
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* corner = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
    auto* index = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
    if (corner && index) {
      for (const Vector3d& vertex : mesh.vertices) {
        const Vector3d place = scaled(vertex);
        for (int k = 0; k < 3; ++k) *corner++ = static_cast<float>(place[k]);
      }
      for (const Vector3i& t : mesh.triangles)
        for (const int k : t) *index++ = static_cast<unsigned>(k);
      rtcCommitGeometry(geometry);
      scene_ = rtcNewScene(device_);
      rtcSetSceneFlags(scene_, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
      rtcAttachGeometry(scene_, geometry);
      rtcCommitScene(scene_);
    }
    rtcReleaseGeometry(geometry);
    if (const RTCError error = rtcGetDeviceError(device_); error != RTC_ERROR_NONE) {
      release();
      throw std::runtime_error("expose: Embree does not take the mesh of " + std::to_string(mesh.triangles.size()) + " triangles: error " +
                               std::to_string(error));
    }
  }
  ~Scene() { release(); }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  Vector3d scaled(const Vector3d& place) const { return scale_ * (place - centre_); }
  double scale() const { return scale_; }

  /// Places and directions of all rays are scaled ones.
  bool occluded(const Vector3d& origin, const Vector3d& direction) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay ray = ray_of(origin, direction, std::numeric_limits<float>::infinity());
    rtcOccluded1(scene_, &context, &ray);
    return ray.tfar < 0.0f;
  }

  /// Rays side by side: 8 of them cost half of what they cost one by one.
  struct Ray {
    Vector3d origin, direction;
  };
  /// @param rays  at most 8   @return a bit for each that meets something
  unsigned occluded(std::span<const Ray> rays) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(32) std::array<int, 8> valid{};
    RTCRay8 packet{};
    for (std::size_t k = 0; k < rays.size(); ++k) {
      valid[k] = -1;
      const RTCRay ray = ray_of(rays[k].origin, rays[k].direction, std::numeric_limits<float>::infinity());
      packet.org_x[k] = ray.org_x, packet.org_y[k] = ray.org_y, packet.org_z[k] = ray.org_z;
      packet.dir_x[k] = ray.dir_x, packet.dir_y[k] = ray.dir_y, packet.dir_z[k] = ray.dir_z;
      packet.tfar[k] = ray.tfar;
      packet.mask[k] = ray.mask;
    }
    rtcOccluded8(valid.data(), scene_, &context, &packet);
    unsigned hits = 0;
    for (std::size_t k = 0; k < rays.size(); ++k)
      if (packet.tfar[k] < 0.0f) hits |= 1u << k;
    return hits;
  }

  struct Hit {
    int triangle = -1;
    double along = 0.0;  ///< cosine between the ray and the triangle's normal
  };
  Hit first_hit(const Vector3d& origin, const Vector3d& direction) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit found{.ray = ray_of(origin, direction, std::numeric_limits<float>::infinity()), .hit = {}};
    found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &found);
    if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    return {static_cast<int>(found.hit.primID), Vector3d(found.hit.Ng_x, found.hit.Ng_y, found.hit.Ng_z).normalized().dot(direction)};
  }

  /// Everything on a short way, in any order.
  std::vector<Hit> all_hits(const Vector3d& origin, const Vector3d& direction, double length) const {
    struct Collecting : RTCIntersectContext {
      std::vector<Hit> hits;
      Vector3d direction;
    } context;
    rtcInitIntersectContext(&context);
    context.direction = direction;
    context.filter = [](const RTCFilterFunctionNArguments* arguments) {
      auto& self = *static_cast<Collecting*>(arguments->context);
      const auto* hit = reinterpret_cast<const RTCHit*>(arguments->hit);  // rays go one by one: N is 1
      self.hits.push_back({static_cast<int>(hit->primID), Vector3d(hit->Ng_x, hit->Ng_y, hit->Ng_z).normalized().dot(self.direction)});
      arguments->valid[0] = 0;  // go on
    };
    RTCRayHit found{.ray = ray_of(origin, direction, static_cast<float>(length)), .hit = {}};
    found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &found);
    return std::move(context.hits);
  }

 private:
  static RTCRay ray_of(const Vector3d& origin, const Vector3d& direction, float length) {
    RTCRay ray{};
    ray.org_x = static_cast<float>(origin.x()), ray.org_y = static_cast<float>(origin.y()), ray.org_z = static_cast<float>(origin.z());
    ray.dir_x = static_cast<float>(direction.x());
    ray.dir_y = static_cast<float>(direction.y());
    ray.dir_z = static_cast<float>(direction.z());
    ray.tfar = length;
    ray.mask = ~0u;
    return ray;
  }
  void release() {
    if (scene_) rtcReleaseScene(scene_);
    if (device_) rtcReleaseDevice(device_);
    scene_ = nullptr, device_ = nullptr;
  }

  Vector3d centre_;
  double scale_ = 1.0;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

/// One triangle, scaled.
struct Facet {
  Vector3d a, ab, ac, normal;
  double area;
  Facet(const Scene& scene, const TriangleMesh& mesh, std::size_t i) {
    const Vector3i& t = mesh.triangles[i];
    // Differences before the scale: far off the origin a corner's place keeps fewer digits than its distance from the next.
    const Vector3d corner = mesh.vertices[static_cast<std::size_t>(t[0])];
    a = scene.scaled(corner);
    ab = scene.scale() * (mesh.vertices[static_cast<std::size_t>(t[1])] - corner);
    ac = scene.scale() * (mesh.vertices[static_cast<std::size_t>(t[2])] - corner);
    const Vector3d cross = ab.cross(ac);
    normal = cross.stableNormalized();
    area = 0.5 * cross.stableNorm();
  }
  /// Point k of n, evenly spread whatever n is: the additive sequence of the plastic number, folded into the triangle.
  std::pair<double, double> place(int k, int n) const {
    if (n == 1) return {1.0 / 3.0, 1.0 / 3.0};
    double s = std::fmod(0.5 + 0.75487766624669276 * (k + 1), 1.0), t = std::fmod(0.5 + 0.56984029099805327 * (k + 1), 1.0);
    if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
    return {s, t};
  }
};

class Exposer {
 public:
  Exposer(Preparation prepared, const ExposeOptions& options)
      : threads_(options.threads > 0 ? options.threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
        rays_(options.rays),
        prepared_(std::move(prepared)),
        scene_(prepared_.mesh, threads_) {
    const std::size_t count = prepared_.mesh.triangles.size();
    areas_.reserve(count);
    for (std::size_t i = 0; i < count; ++i) areas_.push_back(Facet(scene_, prepared_.mesh, i).area);
    total_area_ = std::accumulate(areas_.begin(), areas_.end(), 0.0);
    first_point_.reserve(count + 1);
    first_point_.push_back(0);
    for (const double own : areas_) {
      const int points = total_area_ > 0.0 ? std::clamp(static_cast<int>(coarse_points * own / total_area_), 1, 256) : 1;
      first_point_.push_back(first_point_.back() + static_cast<std::size_t>(points));
    }
    bodies_ = static_cast<int>(std::count(prepared_.sheet.begin(), prepared_.sheet.end(), false));
    // Of all directions about 0.6 are cast: those that a side faces, and a rim beyond.
    const auto halvings_for = [&](std::size_t points) {
      const auto fits = [&](double directions) { return 0.6 * directions * static_cast<double>(points) <= rays_; };
      return fits(642) ? 3 : fits(162) ? 2 : 1;
    };
    // A point that is hidden costs a ray for each of these directions, others a few.
    const std::size_t points = first_point_.back();
    const DirectionSphere hiding(halvings_for(points));
    hiding_ = hiding.directions();
    rim_ = rim_of(hiding);
    int halvings = options.directions == 642 ? 3 : options.directions == 162 ? 2 : 1;
    if (options.directions == 0) halvings = halvings_for(std::min(points, 2 * most_rows));
    sphere_ = DirectionSphere(halvings);
    adapt_ = options.directions == 0 && halvings == 3;
  }

  Preparation result() {
    const std::size_t count = prepared_.mesh.triangles.size();
    pieces_.resize(count);
    layers_.assign(first_point_.back(), {0, 0});
    in_parallel(count, 256, [&](std::size_t first, std::size_t last) {
      Pairs touching_parts;
      for (std::size_t i = first; i < last; ++i) find_wetted(i, touching_parts);
      const std::lock_guard lock(gate_);
      pairs_.merge(touching_parts);
    });
    prepared_.exposed = true;
    // What is hidden altogether, two skins of one thing back to back, say, has no better answer than the mesh itself.
    if (std::none_of(pieces_.begin(), pieces_.end(), [](const WettedPiece& piece) { return piece.front > 0.0 || piece.back > 0.0; }))
      return std::move(prepared_);
    join_parts();
    spread_points();
    rim_ = rim_of(sphere_);
    const bool shelter = look_around();
    leave_out_hidden();
    if (shelter) prepared_.exposure = made();
    return std::move(prepared_);
  }

 private:
  /// Points on a coarse mesh, spread by area.
  static constexpr double coarse_points = 4096.0;
  /// Triangles of which each has a row of its own; of more, neighbours share one.
  static constexpr std::size_t most_rows = 4096;
  /// Error of the windward area half-way between two directions above which they get another between them [its share].
  static constexpr double tolerance = 0.02;
  /// Edges below twice this are not halved: directions come no nearer to each other than about 1 degree.
  static constexpr double nearest = 0.01;

  using Pairs = std::set<std::pair<int, int>>;
  using Column = std::vector<std::uint8_t>;  ///< share of every row from one direction, 0 to 255

  /// Where rays start, on one or both sides of a triangle.
  struct Point {
    Vector3d foot, normal;
    double lift = 0.0, area = 0.0;
    int row = 0, part = 0;
    bool sheet = false;
    std::array<double, 2> weight{};  ///< of front and back; 0 where hidden
  };

  /// What the wind from one direction reaches, and by how much its neighbours in the middle of which it lies would have it wrong.
  struct View {
    Column column;
    double error = 0.0;
  };

  int part_of(int triangle) const { return prepared_.part[static_cast<std::size_t>(triangle)]; }
  bool is_sheet(int part) const { return prepared_.sheet[static_cast<std::size_t>(part)]; }

  /// Least c at which a direction is of any use to a side: farther behind it than a cell is wide it is never asked for.
  static double rim_of(const DirectionSphere& sphere) {
    double widest = 1.0;
    for (const Exposure::Cell& cell : sphere.cells())
      for (int k = 0; k < 3 && cell.children == 0; ++k) {
        const auto [a, b] = DirectionSphere::edge(cell, k);
        widest = std::min(widest, sphere.directions()[static_cast<std::size_t>(a)].dot(sphere.directions()[static_cast<std::size_t>(b)]));
      }
    return -std::sqrt(1.0 - widest * widest);
  }

  /// A ray's direction: those behind a side, or all but along it, go just above it.
  static Vector3d lifted(const Vector3d& towards, const Vector3d& normal, double c) {
    if (c >= least_c) return towards;
    return (towards - c * normal).normalized() * std::sqrt(1.0 - least_c * least_c) + least_c * normal;
  }

  /// Calls work(first, last) for blocks of 0 to count. Blocks are independent of each other, so that the result does not depend on who
  /// does which.
  template <class Work>
  void in_parallel(std::size_t count, std::size_t most, Work&& work) {
    const std::size_t block = std::clamp<std::size_t>(count / 64, 1, most);
    std::atomic<std::size_t> next{0};
    std::exception_ptr failure;
    const auto take = [&] {
      try {
        for (std::size_t first = next.fetch_add(block); first < count; first = next.fetch_add(block))
          work(first, std::min(count, first + block));
      } catch (...) {
        const std::lock_guard lock(gate_);
        failure = std::current_exception();
      }
    };
    {
      std::vector<std::jthread> others;
      for (int k = 1; k < threads_; ++k) others.emplace_back(take);
      take();
    }
    if (failure) std::rethrow_exception(failure);
  }

  static double lift_of(const Facet& facet) { return std::max(1e-4 * std::sqrt(2.0 * facet.area), 1e-5); }

  /// Which of a triangle's points some direction reaches, and the piece that they stand for.
  void find_wetted(std::size_t i, Pairs& touching_parts) {
    const Facet facet(scene_, prepared_.mesh, i);
    const int part = prepared_.part[i];
    const bool sheet = is_sheet(part);
    const Vector3i& t = prepared_.mesh.triangles[i];
    const Vector3d corner = prepared_.mesh.vertices[static_cast<std::size_t>(t[0])];
    const Vector3d ab = prepared_.mesh.vertices[static_cast<std::size_t>(t[1])] - corner,
                   ac = prepared_.mesh.vertices[static_cast<std::size_t>(t[2])] - corner;
    WettedPiece& piece = pieces_[i];
    const Vector3d whole = corner + (ab + ac) / 3.0;
    piece = {.front = 1.0, .back = 1.0, .centroid = whole};
    if (!(facet.area > 0.0)) return;  // without a normal it has no side; it carries no force
    const double lift = lift_of(facet);
    const auto n = static_cast<int>(first_point_[i + 1] - first_point_[i]);

    for (const int side : {1, -1}) {
      if (side < 0 && !sheet) break;
      const Vector3d normal = side * facet.normal;
      double weight = 0.0;
      Vector3d moment = Vector3d::Zero();
      for (int k = 0; k < n; ++k) {
        const auto [s, u] = facet.place(k, n);
        const Vector3d foot = facet.a + s * facet.ab + u * facet.ac, origin = foot + lift * normal;
        if (!has_a_way_out(origin, normal, lift, sheet ? (side > 0 ? 0.0 : std::numeric_limits<double>::min()) : rim_)) {
          if (!sheet) find_touching(part, foot, normal, lift, touching_parts);
          continue;
        }
        const int skins = sheet || bodies_ < 2 ? 1 : layers(part, origin, normal, lift, touching_parts);
        layers_[first_point_[i] + static_cast<std::size_t>(k)][side > 0 ? 0 : 1] = static_cast<std::uint8_t>(std::min(skins, 255));
        weight += 1.0 / skins;
        moment += (s * ab + u * ac) / skins;
      }
      const double share = weight / n;
      if (share < 1.0 && (side > 0 || share > piece.front)) piece.centroid = weight > 0.0 ? Vector3d(corner + moment / weight) : whole;
      if (side < 0 && share >= 1.0) piece.centroid = whole;  // the side with more of it counts
      (side > 0 ? piece.front : piece.back) = share;
      if (!sheet) piece.back = 0.0;
    }
  }

  /// @param least  cosine that a direction has at least with the normal
  bool has_a_way_out(const Vector3d& origin, const Vector3d& normal, double lift, double least) const {
    int ways = 0;
    Vector3d last;
    for (const Vector3d& direction : hiding_) {
      const double c = normal.dot(direction);
      if (c < least) continue;
      const Vector3d towards = lifted(direction, normal, c);
      if (scene_.occluded(origin, towards)) continue;
      last = towards;
      if (++ways == 2) return true;
    }
    // One way out of a sealed place may be a ray that slipped between two triangles: from a hair beside it would not.
    return ways == 1 && !scene_.occluded(origin + 0.37 * lift * normal.unitOrthogonal(), last);
  }

  /// Rows, and the points that speak for them: all of a coarse mesh; of a fine one, one for each group of neighbours that face alike.
  void spread_points() {
    const std::size_t count = areas_.size();
    row_.resize(count);
    const auto add = [&](std::size_t i, const Facet& facet, int k, int n, double area) {
      const auto [s, u] = facet.place(k, n);
      const int part = prepared_.part[i];
      Point point{.foot = facet.a + s * facet.ab + u * facet.ac,
                  .normal = facet.normal,
                  .lift = lift_of(facet),
                  .area = area,
                  .row = row_[i],
                  .part = part,
                  .sheet = is_sheet(part)};
      for (std::size_t side = 0; side < 2; ++side)
        if (const int skins = layers_[first_point_[i] + static_cast<std::size_t>(k)][side]; skins > 0) point.weight[side] = 1.0 / skins;
      if (point.weight[0] > 0.0 || point.weight[1] > 0.0) points_.push_back(point);
    };
    if (count <= most_rows) {
      std::iota(row_.begin(), row_.end(), 0);
      rows_ = count;
      for (std::size_t i = 0; i < count; ++i) {
        const Facet facet(scene_, prepared_.mesh, i);
        const auto n = static_cast<int>(first_point_[i + 1] - first_point_[i]);
        for (int k = 0; facet.area > 0.0 && k < n; ++k) add(i, facet, k, n, facet.area / n);
      }
      return;
    }
    // What is hidden needs no row.
    std::vector<Grouped> grouped;
    for (std::size_t i = 0; i < count; ++i) {
      row_[i] = 0;
      if (!(areas_[i] > 0.0) || !(pieces_[i].front > 0.0 || pieces_[i].back > 0.0)) continue;
      const Facet facet(scene_, prepared_.mesh, i);
      Grouped own{.triangle = static_cast<int>(i), .area = static_cast<float>(areas_[i])};
      const Vector3d centre = facet.a + (facet.ab + facet.ac) / 3.0;
      for (std::size_t k = 0; k < 3; ++k) {
        own.feature[k] = static_cast<float>(centre[static_cast<Eigen::Index>(k)]);
        own.feature[3 + k] = static_cast<float>(turning * facet.normal[static_cast<Eigen::Index>(k)]);
      }
      grouped.push_back(own);
    }
    std::stable_sort(grouped.begin(), grouped.end(),
                     [&](const Grouped& a, const Grouped& b) { return part_of(a.triangle) < part_of(b.triangle); });
    for (std::size_t first = 0; first < grouped.size();) {
      std::size_t last = first + 1;
      while (last < grouped.size() && part_of(grouped[last].triangle) == part_of(grouped[first].triangle)) ++last;
      group(std::span(grouped).subspan(first, last - first), [&](std::span<const Grouped> members, double area) {
        const int row = static_cast<int>(rows_++);
        for (const Grouped& member : members) row_[static_cast<std::size_t>(member.triangle)] = row;
        // A large triangle in a row of its own keeps all of its points; of a group one speaks for all, from the middle of its area.
        double passed = 0.0;
        const auto chosen = std::find_if(members.begin(), members.end(), [&](const Grouped& member) {
          passed += member.area;
          return passed >= 0.5 * area;
        });
        const auto i = static_cast<std::size_t>(chosen == members.end() ? members.back().triangle : chosen->triangle);
        const Facet facet(scene_, prepared_.mesh, i);
        const auto n = static_cast<int>(first_point_[i + 1] - first_point_[i]);
        const int own = members.size() == 1 ? n : 1;
        for (int k = 0; k < own; ++k) add(i, facet, k, n, area / own);
      });
      first = last;
    }
  }

  /// A triangle among those that may share a row: place, and normal in a unit in which 25 degrees are as far as a row is wide.
  struct Grouped {
    int triangle = 0;
    float area = 0.0f;
    std::array<float, 6> feature{};
  };
  static constexpr double turning = 0.1;

  /// Halves a set of triangles, where it spreads most, until each part is small; calls visit(members, area).
  template <class Visit>
  void group(std::span<Grouped> members, const Visit& visit) {
    double area = 0.0;
    std::array<float, 6> low, high;
    low.fill(std::numeric_limits<float>::infinity()), high.fill(-std::numeric_limits<float>::infinity());
    for (const Grouped& member : members) {
      area += member.area;
      for (std::size_t k = 0; k < 6; ++k) {
        low[k] = std::min(low[k], member.feature[k]);
        high[k] = std::max(high[k], member.feature[k]);
      }
    }
    if (members.size() == 1 || area <= total_area_ / static_cast<double>(most_rows)) {
      visit(members, area);
      return;
    }
    std::size_t widest = 0;
    for (std::size_t k = 1; k < 6; ++k)
      if (high[k] - low[k] > high[widest] - low[widest]) widest = k;
    const auto middle = members.begin() + static_cast<std::ptrdiff_t>(members.size() / 2);
    std::nth_element(members.begin(), middle, members.end(), [&](const Grouped& a, const Grouped& b) {
      return a.feature[widest] != b.feature[widest] ? a.feature[widest] < b.feature[widest] : a.triangle < b.triangle;
    });
    group(members.subspan(0, members.size() / 2), visit);
    group(members.subspan(members.size() / 2), visit);
  }

  /// @return the share of every row that a direction reaches; 255 where it faces none of it
  Column cast(const Vector3d& direction) const {
    std::vector<double> seen(rows_, 0.0), all(rows_, 0.0);
    std::array<Scene::Ray, 8> rays;
    std::array<std::pair<int, double>, 8> rows;
    std::size_t waiting = 0;
    const auto flush = [&] {
      const unsigned hits = scene_.occluded(std::span(rays.data(), waiting));
      for (std::size_t k = 0; k < waiting; ++k)
        if ((hits >> k & 1u) == 0) seen[static_cast<std::size_t>(rows[k].first)] += rows[k].second;
      waiting = 0;
    };
    for (const Point& point : points_) {
      const double c = point.normal.dot(direction);
      // Of a sheet each direction is one side's.
      const bool back = point.sheet && c < 0.0;
      const double weight = point.weight[back ? 1 : 0];
      if (!(weight > 0.0) || (!point.sheet && c < rim_)) continue;
      const Vector3d normal = back ? Vector3d(-point.normal) : point.normal;
      all[static_cast<std::size_t>(point.row)] += weight;
      rays[waiting] = {point.foot + point.lift * normal, lifted(direction, normal, back ? -c : c)};
      rows[waiting] = {point.row, weight};
      if (++waiting == rays.size()) flush();
    }
    if (waiting > 0) flush();
    Column column(rows_, 255);
    for (std::size_t r = 0; r < rows_; ++r)
      if (all[r] > 0.0) column[r] = static_cast<std::uint8_t>(std::lround(255.0 * seen[r] / all[r]));
    return column;
  }

  /// How far from the windward area that a direction reaches its two neighbours' mean is, as a share of it, part by part.
  double error_of(const Vector3d& direction, const Column& own, const Column& first, const Column& second) const {
    std::vector<double> error(prepared_.sheet.size(), 0.0);
    double reached = 0.0;
    for (const Point& point : points_) {
      const double c = point.normal.dot(direction), facing = point.sheet ? std::abs(c) : c;
      const double windward = facing * point.area * point.weight[point.sheet && c < 0.0 ? 1 : 0] / 255.0;
      if (!(windward > 0.0)) continue;
      const auto r = static_cast<std::size_t>(point.row);
      reached += windward * own[r];
      error[static_cast<std::size_t>(point.part)] += windward * (0.5 * (first[r] + second[r]) - own[r]);
    }
    double sum = 0.0;
    for (const double part : error) sum += std::abs(part);
    return sum / std::max(reached, 1e-3 * total_area_);  // seen edge-on, a sheet has no area to be a share of
  }

  /// Looks from the middle of each of these edges.
  std::vector<View> look_from(const std::vector<DirectionSphere::Edge>& edges) {
    std::vector<View> views(edges.size());
    in_parallel(edges.size(), 16, [&](std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) {
        const Vector3d direction = sphere_.middle(edges[k]);
        views[k].column = cast(direction);
        views[k].error = error_of(direction, views[k].column, columns_[static_cast<std::size_t>(edges[k].first)],
                                  columns_[static_cast<std::size_t>(edges[k].second)]);
      }
    });
    return views;
  }

  /// Looks from all directions, and from more of them where the shadows change fast. @return whether anything stands in a wind
  bool look_around() {
    const std::size_t even = sphere_.directions().size();
    columns_.resize(even);
    in_parallel(even, 16, [&](std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) columns_[k] = cast(sphere_.directions()[k]);
    });
    if (std::all_of(columns_.begin(), columns_.end(), [](const Column& column) {
          return std::all_of(column.begin(), column.end(), [](std::uint8_t share) { return share == 255; });
        }))
      return false;
    // How wrong each direction would have been without it.
    surplus_.assign(even, 0.0);
    for (std::size_t k = 12; k < even; ++k) {
      const auto [a, b] = sphere_.parents()[k];
      surplus_[k] =
          error_of(sphere_.directions()[k], columns_[k], columns_[static_cast<std::size_t>(a)], columns_[static_cast<std::size_t>(b)]);
    }
    if (adapt_)
      while (refine()) {
      }
    return true;
  }

  /// How wrong the interpolation half-way along an edge of a whole cell is, as far as is known.
  double error_at(const Exposure::Cell& cell, const DirectionSphere::Edge& edge) const {
    if (const auto seen = views_.find(edge); seen != views_.end()) return seen->second.error;
    // From what its corners put right when they were put in the middle of others: a kink's error grows with the distance.
    double error = 0.0;
    for (const int corner : cell.corner)
      if (corner >= 12) {
        const auto c = static_cast<std::size_t>(corner);
        error = std::max(error, surplus_[c] * sphere_.length(edge) / sphere_.length(sphere_.parents()[c]));
      }
    return error;
  }

  template <class Visit>
  void for_each_edge(const Visit& visit) const {
    for (const Exposure::Cell& cell : sphere_.cells())
      for (int k = 0; k < 3 && cell.children == 0; ++k) visit(cell, DirectionSphere::edge(cell, k));
  }

  /// One round. The middles of edges are looked from where the error of the round before tells that the interpolation may be wrong, and
  /// become directions where it is. @return whether there may be more to find
  bool refine() {
    const double cost = 0.6 * static_cast<double>(points_.size());
    std::map<DirectionSphere::Edge, double> expected;
    for_each_edge([&](const Exposure::Cell& cell, const DirectionSphere::Edge& edge) {
      if (sphere_.length(edge) < 2.0 * nearest || views_.contains(edge)) return;
      if (const double error = error_at(cell, edge); error > 0.5 * tolerance) expected[edge] = std::max(expected[edge], error);
    });
    std::vector<DirectionSphere::Edge> edges;
    for (const auto& [edge, error] : expected) edges.push_back(edge);
    std::stable_sort(edges.begin(), edges.end(), [&](const auto& a, const auto& b) { return expected[a] > expected[b]; });
    const double left = rays_ - cost * static_cast<double>(columns_.size() + views_.size());
    const auto affordable = static_cast<std::size_t>(std::max(0.0, left / cost));
    const bool all = edges.size() <= affordable;
    if (!all) edges.resize(affordable);

    std::vector<View> views = look_from(edges);
    std::set<DirectionSphere::Edge> wrong;
    for (std::size_t k = 0; k < edges.size(); ++k) {
      if (views[k].error > tolerance) wrong.insert(edges[k]);
      views_.emplace(edges[k], std::move(views[k]));
    }
    if (wrong.empty()) return false;
    sphere_.halve(std::move(wrong));
    // Some are halved for their neighbours' sake alone, and nobody has looked from there.
    const std::size_t before = columns_.size();
    std::vector<DirectionSphere::Edge> others;
    for (std::size_t k = before; k < sphere_.directions().size(); ++k)
      if (!views_.contains(sphere_.parents()[k])) others.push_back(sphere_.parents()[k]);
    std::vector<View> more = look_from(others);
    for (std::size_t k = 0; k < others.size(); ++k) views_.emplace(others[k], std::move(more[k]));
    for (std::size_t k = before; k < sphere_.directions().size(); ++k) {
      const auto node = views_.extract(sphere_.parents()[k]);
      columns_.push_back(std::move(node.mapped().column));
      surplus_.push_back(node.mapped().error);
    }
    return all;
  }

  std::shared_ptr<const Exposure> made() {
    auto exposure = std::make_shared<Exposure>();
    exposure->directions = sphere_.directions();
    exposure->cells = sphere_.cells();
    for_each_edge([&](const Exposure::Cell& cell, const DirectionSphere::Edge& edge) {
      exposure->residual = std::max(exposure->residual, error_at(cell, edge));
    });
    // Rows of triangles that are left.
    std::vector<int> renumbered(rows_, -1);
    int rows = 0;
    for (int& row : row_) {
      int& own = renumbered[static_cast<std::size_t>(row)];
      if (own < 0) own = rows++;
      row = own;
    }
    exposure->row = std::move(row_);
    exposure->reached.resize(rows, static_cast<Eigen::Index>(columns_.size()));
    for (std::size_t d = 0; d < columns_.size(); ++d)
      for (std::size_t r = 0; r < rows_; ++r)
        if (renumbered[r] >= 0) exposure->reached(renumbered[r], static_cast<Eigen::Index>(d)) = columns_[d][r];
    return exposure;
  }

  /// How many bodies have a skin at this place that faces the same way.
  int layers(int part, const Vector3d& origin, const Vector3d& normal, double lift, Pairs& touching_parts) const {
    std::set<int> others;
    for (const Scene::Hit& hit : scene_.all_hits(origin, -normal, 2.0 * lift)) {
      const int other = part_of(hit.triangle);
      if (other != part && !is_sheet(other) && hit.along < -0.999) others.insert(other);
    }
    for (const int other : others) touching_parts.insert(std::minmax(part, other));
    return 1 + static_cast<int>(others.size());
  }

  /// Bodies that cover a hidden point: their skin lies on it, or it is inside of them.
  void find_touching(int part, const Vector3d& foot, const Vector3d& normal, double lift, Pairs& touching_parts) const {
    if (bodies_ < 2) return;
    const auto is_other_body = [&](int other) { return other != part && !is_sheet(other); };
    for (const Scene::Hit& hit : scene_.all_hits(foot - lift * normal, normal, lift + touching))
      if (const int other = part_of(hit.triangle); is_other_body(other)) touching_parts.insert(std::minmax(part, other));
    const Vector3d right = normal.unitOrthogonal(), up = normal.cross(right);
    std::map<int, int> inside;
    for (const auto& [x, y] : {std::pair{0.1, 0.2}, {0.9, 0.3}, {-0.4, 0.8}, {-0.7, -0.6}, {0.5, -0.9}}) {
      const Scene::Hit hit = scene_.first_hit(foot + lift * normal, (normal + x * right + y * up).normalized());
      if (hit.triangle >= 0 && hit.along > 0.0 && is_other_body(part_of(hit.triangle))) ++inside[part_of(hit.triangle)];
    }
    for (const auto& [other, votes] : inside)
      if (votes >= 2) touching_parts.insert(std::minmax(part, other));
  }

  void report(Finding::Kind kind, int count, double area, const std::string& what, const std::string& text) {
    if (count == 0) return;
    std::ostringstream line;
    line.precision(4);
    line << count << " " << what << (count == 1 ? "" : "s");
    if (area > 0.0) line << " (" << area << " m^2)";
    line << text;
    prepared_.report.push_back({kind, count, area, line.str()});
  }

  void join_parts() {
    if (pairs_.empty()) return;
    DisjointSets sets(prepared_.sheet.size());
    for (const auto& [a, b] : pairs_) sets.join(a, b);
    int number = 0;
    const std::vector<int> label = sets.labels(number);
    std::vector<int> members(static_cast<std::size_t>(number), 0);
    std::vector<bool> sheet(static_cast<std::size_t>(number), false);
    for (std::size_t p = 0; p < label.size(); ++p) {
      ++members[static_cast<std::size_t>(label[p])];
      sheet[static_cast<std::size_t>(label[p])] = prepared_.sheet[p];
    }
    double area = 0.0;
    for (std::size_t i = 0; i < prepared_.part.size(); ++i) {
      int& part = prepared_.part[i];
      part = label[static_cast<std::size_t>(part)];
      if (members[static_cast<std::size_t>(part)] > 1) area += area_of(i);
    }
    prepared_.sheet = std::move(sheet);
    int shells = 0;
    for (const int count : members) shells += count > 1 ? count : 0;
    report(Finding::Kind::joined, shells, area, "shell", " touching or overlapping: taken as one body where they do");
  }

  double area_of(std::size_t i) const { return Facet(scene_, prepared_.mesh, i).area / (scene_.scale() * scene_.scale()); }

  void leave_out_hidden() {
    const std::size_t count = pieces_.size();
    std::size_t kept = 0;
    int covered = 0;
    double hidden_area = 0.0, covered_area = 0.0;
    std::vector<bool> has_triangles(prepared_.sheet.size(), false);
    for (std::size_t i = 0; i < count; ++i) {
      const WettedPiece& piece = pieces_[i];
      const auto part = static_cast<std::size_t>(prepared_.part[i]);
      const double area = area_of(i);
      if (!(piece.front > 0.0) && !(piece.back > 0.0)) {
        hidden_area += area;
        continue;
      }
      has_triangles[part] = true;
      if (const double missing = 1.0 - piece.front + (prepared_.sheet[part] ? 1.0 - piece.back : 0.0); missing > 0.0) {
        ++covered;
        covered_area += area * missing;
      }
      prepared_.mesh.triangles[kept] = prepared_.mesh.triangles[i];
      prepared_.part[kept] = prepared_.part[i];
      prepared_.lid[kept] = prepared_.lid[i];
      pieces_[kept] = pieces_[i];
      row_[kept] = row_[i];
      ++kept;
    }
    prepared_.mesh.triangles.resize(kept);
    prepared_.part.resize(kept);
    prepared_.lid.resize(kept);
    pieces_.resize(kept);
    row_.resize(kept);
    // Parts of which nothing is left go with their triangles.
    std::vector<int> number(has_triangles.size(), 0);
    int parts = 0;
    for (std::size_t p = 0; p < number.size(); ++p)
      if (has_triangles[p]) {
        prepared_.sheet[static_cast<std::size_t>(parts)] = prepared_.sheet[p];
        number[p] = parts++;
      }
    prepared_.sheet.resize(static_cast<std::size_t>(parts));
    for (int& part : prepared_.part) part = number[static_cast<std::size_t>(part)];
    report(Finding::Kind::hidden, static_cast<int>(count - kept), hidden_area, "triangle", " that no wind reaches: left out");
    report(Finding::Kind::covered, covered, covered_area, "triangle", " covered in part by others: the rest counts");
    if (covered > 0) prepared_.wetted = std::move(pieces_);
  }

  int threads_;
  double rays_;
  Preparation prepared_;
  Scene scene_;
  std::mutex gate_;
  std::vector<double> areas_;  ///< of every triangle, scaled
  double total_area_ = 0.0;
  std::vector<std::size_t> first_point_;             ///< of every triangle, and one past the last
  std::vector<std::array<std::uint8_t, 2>> layers_;  ///< of every point's front and back: bodies with a skin there; 0 where hidden
  std::vector<Vector3d> hiding_;                     ///< directions none of which reaches what is hidden
  double rim_ = 0.0;
  int bodies_ = 0;
  std::vector<WettedPiece> pieces_;
  std::vector<Point> points_;
  std::vector<int> row_;  ///< of every triangle
  std::size_t rows_ = 0;
  DirectionSphere sphere_{0};
  bool adapt_ = false;
  std::vector<Column> columns_;                  ///< of every direction
  std::vector<double> surplus_;                  ///< of every direction: how wrong the mean of the two it lies between was
  std::map<DirectionSphere::Edge, View> views_;  ///< from the middle of whole edges
  Pairs pairs_;                                  ///< of parts that touch
};

double silhouette_area(const Scene& scene, const TriangleMesh& mesh, const Vector3d& along) {
  constexpr int rows = 512;
  const Vector3d right = along.unitOrthogonal(), up = along.cross(right);
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vector3i& t : mesh.triangles)
    for (const int corner : t) {
      const Vector3d place = scene.scaled(mesh.vertices[static_cast<std::size_t>(corner)]);
      const Eigen::Array2d flat(place.dot(right), place.dot(up));
      low = low.min(flat);
      high = high.max(flat);
    }
  const Eigen::Array2d step = (high - low) / rows;
  int hits = 0;
  for (int x = 0; x < rows; ++x)
    for (int y = 0; y < rows; ++y)
      hits += scene.occluded(2.0 * along + (low[0] + (x + 0.5) * step[0]) * right + (low[1] + (y + 0.5) * step[1]) * up, -along);
  return hits * step[0] * step[1] / (scene.scale() * scene.scale());
}

int all_threads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

}  // namespace

Preparation expose(Preparation prepared, const ExposeOptions& options) {
  if (options.directions != 0 && options.directions != 42 && options.directions != 162 && options.directions != 642)
    throw std::invalid_argument("expose: directions = " + std::to_string(options.directions) +
                                "; needed is 42, 162, 642, or 0 for as many as fit");
  if (!(options.rays > 0.0)) throw std::invalid_argument("expose: rays = " + std::to_string(options.rays) + "; needed is more than 0");
  if (options.threads < 0)
    throw std::invalid_argument("expose: threads = " + std::to_string(options.threads) + "; needed is at least 0, for all cores");
  if (prepared.exposed) return prepared;
  if (prepared.mesh.triangles.empty() || is_convex(prepared)) {
    prepared.exposed = true;
    return prepared;
  }
  return Exposer(std::move(prepared), options).result();
}

double silhouette_area(const TriangleMesh& mesh, const Vector3d& direction) {
  validate(mesh);
  if (!direction.allFinite() || !(direction.stableNorm() > 0.0))
    throw std::invalid_argument("silhouette: the direction has no length, or is not finite");
  if (mesh.triangles.empty()) return 0.0;
  return silhouette_area(Scene(mesh, all_threads()), mesh, direction.stableNormalized());
}

std::array<WindwardRatio, 6> windward_over_silhouette(const Preparation& before) {
  std::array<WindwardRatio, 6> ratios;
  const bool empty = before.mesh.triangles.empty();
  const TriangleMesh& mesh = before.mesh;
  for (int k = 0; k < 6; ++k) {
    const Vector3d towards = (k % 2 == 0 ? 1.0 : -1.0) * Vector3d::Unit(k / 2);
    double summed = 0.0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const Vector3d a = mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][0])];
      const double facing = 0.5 * (mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][1])] - a)
                                      .cross(mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][2])] - a)
                                      .dot(towards);
      summed += before.sheet[static_cast<std::size_t>(before.part[i])] ? std::abs(facing) : std::max(0.0, facing);
    }
    ratios[static_cast<std::size_t>(k)] = {towards, summed, 0.0};
  }
  if (empty) return ratios;
  const Scene scene(mesh, all_threads());
  for (std::size_t axis = 0; axis < 3; ++axis)  // one sees the same outline from both ends
    ratios[2 * axis].silhouette = ratios[2 * axis + 1].silhouette = silhouette_area(scene, mesh, ratios[2 * axis].direction);
  return ratios;
}

}  // namespace dragcore
