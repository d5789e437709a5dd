#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <dragcore/expose.hpp>
#include <dragcore/surface.hpp>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "body/edges.hpp"

namespace dragcore {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// Least c at which a ray leaves a side: nearer to edge-on the float's rounding decides what it meets.
constexpr double least_c = 0.05;

/// Gap below which two bodies touch, in half diagonals of the mesh's box: what modellers leave between parts that belong together.
constexpr double touching = 1e-3;

struct Sphere {
  std::vector<Vector3d> directions;
  std::vector<Vector3i> cells;
};

/// An icosahedron with its edges halved this many times. Its first midpoints are the six directions of the axes.
Sphere icosphere(int halvings) {
  const double g = std::numbers::phi;
  Sphere sphere{.directions = {{-1, g, 0},
                               {1, g, 0},
                               {-1, -g, 0},
                               {1, -g, 0},
                               {0, -1, g},
                               {0, 1, g},
                               {0, -1, -g},
                               {0, 1, -g},
                               {g, 0, -1},
                               {g, 0, 1},
                               {-g, 0, -1},
                               {-g, 0, 1}}};
  for (Vector3d& corner : sphere.directions) corner.normalize();
  // Its faces are the triples of corners that are all neighbours of each other.
  const auto adjacent = [&](int a, int b) {
    return sphere.directions[static_cast<std::size_t>(a)].dot(sphere.directions[static_cast<std::size_t>(b)]) > 0.4;
  };
  for (int a = 0; a < 12; ++a)
    for (int b = a + 1; b < 12; ++b)
      for (int c = b + 1; c < 12; ++c)
        if (adjacent(a, b) && adjacent(b, c) && adjacent(c, a)) sphere.cells.emplace_back(a, b, c);
  for (; halvings > 0; --halvings) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [place, made] = middles.try_emplace(std::minmax(a, b), static_cast<int>(sphere.directions.size()));
      if (made)
        sphere.directions.push_back(
            (sphere.directions[static_cast<std::size_t>(a)] + sphere.directions[static_cast<std::size_t>(b)]).normalized());
      return place->second;
    };
    std::vector<Vector3i> finer;
    for (const Vector3i& cell : sphere.cells) {
      const int ab = middle(cell[0], cell[1]), bc = middle(cell[1], cell[2]), ca = middle(cell[2], cell[0]);
      finer.insert(finer.end(), {{cell[0], ab, ca}, {ab, cell[1], bc}, {ca, bc, cell[2]}, {ab, bc, ca}});
    }
    sphere.cells = std::move(finer);
  }
  return sphere;
}

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
        prepared_(std::move(prepared)),
        scene_(prepared_.mesh, threads_) {
    const auto& triangles = prepared_.mesh.triangles;
    double area = 0.0;
    std::vector<double> areas;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      areas.push_back(Facet(scene_, prepared_.mesh, i).area);
      area += areas.back();
    }
    std::size_t samples = 0;
    for (const double own : areas) {
      samples_.push_back(area > 0.0 ? std::clamp(static_cast<int>(coarse_samples * own / area), 1, 256) : 1);
      samples += static_cast<std::size_t>(samples_.back());
    }
    // Of all directions about 0.6 are cast: those that a side faces, and a rim beyond.
    int halvings = options.directions == 642 ? 3 : options.directions == 162 ? 2 : 1;
    if (options.directions == 0)
      while (halvings < 3 && 0.6 * static_cast<double>(samples) * (halvings == 1 ? 162 : 642) <= options.rays) ++halvings;
    sphere_ = icosphere(halvings);
    double widest = 1.0;
    for (const Vector3i& cell : sphere_.cells)
      for (int k = 0; k < 3; ++k) widest = std::min(widest, direction(cell[k]).dot(direction(cell[(k + 1) % 3])));
    // Farther behind the side than a cell is wide, a direction is never asked for.
    rim_ = -std::sqrt(1.0 - widest * widest);
    bodies_ = static_cast<int>(std::count(prepared_.sheet.begin(), prepared_.sheet.end(), false));
  }

  Preparation result() {
    const std::size_t count = prepared_.mesh.triangles.size();
    pieces_.resize(count);
    reached_.setConstant(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(sphere_.directions.size()), 255);
    for_all_triangles(count);
    prepared_.exposed = true;
    // What is hidden altogether, two skins of one thing back to back, say, has no better answer than the mesh itself.
    if (std::none_of(pieces_.begin(), pieces_.end(), [](const WettedPiece& piece) { return piece.front > 0.0 || piece.back > 0.0; }))
      return std::move(prepared_);
    join_parts();
    leave_out_hidden();
    if ((reached_ != 255).any()) {
      auto exposure = std::make_shared<Exposure>();
      exposure->directions = std::move(sphere_.directions);
      exposure->cells = std::move(sphere_.cells);
      exposure->reached = std::move(reached_);
      prepared_.exposure = std::move(exposure);
    }
    return std::move(prepared_);
  }

 private:
  /// Points on a coarse mesh, spread by area.
  static constexpr double coarse_samples = 4096.0;

  using Pairs = std::set<std::pair<int, int>>;

  Vector3d direction(int k) const { return sphere_.directions[static_cast<std::size_t>(k)]; }
  int part_of(int triangle) const { return prepared_.part[static_cast<std::size_t>(triangle)]; }
  bool is_sheet(int part) const { return prepared_.sheet[static_cast<std::size_t>(part)]; }

  /// Triangles are independent of each other, so that the result does not depend on who does which.
  void for_all_triangles(std::size_t count) {
    constexpr std::size_t block = 256;
    std::atomic<std::size_t> next{0};
    std::mutex gate;
    std::exception_ptr failure;
    const auto work = [&] {
      try {
        Pairs touching_parts;
        for (std::size_t first = next.fetch_add(block_of(count, block)); first < count; first = next.fetch_add(block_of(count, block)))
          for (std::size_t i = first; i < std::min(count, first + block_of(count, block)); ++i) look_at(i, touching_parts);
        const std::lock_guard lock(gate);
        pairs_.merge(touching_parts);
      } catch (...) {
        const std::lock_guard lock(gate);
        failure = std::current_exception();
      }
    };
    {
      std::vector<std::jthread> others;
      for (int k = 1; k < threads_; ++k) others.emplace_back(work);
      work();
    }
    if (failure) std::rethrow_exception(failure);
  }
  static std::size_t block_of(std::size_t count, std::size_t most) { return std::clamp<std::size_t>(count / 64, 1, most); }

  void look_at(std::size_t i, Pairs& touching_parts) {
    const Facet facet(scene_, prepared_.mesh, i);
    const auto row = static_cast<Eigen::Index>(i);
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
    const double lift = std::max(1e-4 * std::sqrt(2.0 * facet.area), 1e-5);
    const int n = samples_[i];

    for (const int side : {1, -1}) {
      if (side < 0 && !sheet) break;
      const Vector3d normal = side * facet.normal;
      std::vector<std::pair<Eigen::Index, Vector3d>> rays;
      for (std::size_t d = 0; d < sphere_.directions.size(); ++d) {
        const double c = normal.dot(sphere_.directions[d]);
        // Of a sheet each direction is one side's.
        if (sheet ? (side > 0 ? c < 0.0 : c <= 0.0) : c < rim_) continue;
        Vector3d towards = sphere_.directions[d];
        if (c < least_c) towards = (towards - c * normal).normalized() * std::sqrt(1.0 - least_c * least_c) + least_c * normal;
        rays.emplace_back(static_cast<Eigen::Index>(d), towards);
      }

      std::vector<double> seen(rays.size(), 0.0);
      std::vector<char> free(rays.size());
      double weight = 0.0;
      Vector3d moment = Vector3d::Zero();
      for (int k = 0; k < n; ++k) {
        const auto [s, u] = facet.place(k, n);
        const Vector3d foot = facet.a + s * facet.ab + u * facet.ac, origin = foot + lift * normal;
        int ways = 0;
        std::size_t last = 0;
        for (std::size_t r = 0; r < rays.size(); ++r) {
          free[r] = !scene_.occluded(origin, rays[r].second);
          if (free[r]) ++ways, last = r;
        }
        // One way out of a sealed place may be a ray that slipped between two triangles: from a hair beside it would not.
        if (ways == 1 && scene_.occluded(origin + 0.37 * lift * normal.unitOrthogonal(), rays[last].second)) ways = 0;
        if (ways == 0) {
          if (!sheet) find_touching(part, foot, normal, lift, touching_parts);
          continue;
        }
        const double w = sheet || bodies_ < 2 ? 1.0 : 1.0 / layers(part, origin, normal, lift, touching_parts);
        weight += w;
        moment += w * (s * ab + u * ac);
        for (std::size_t r = 0; r < rays.size(); ++r) seen[r] += free[r] ? w : 0.0;
      }
      const double share = weight / n;
      if (share < 1.0 && (side > 0 || share > piece.front)) piece.centroid = weight > 0.0 ? Vector3d(corner + moment / weight) : whole;
      if (side < 0 && share >= 1.0) piece.centroid = whole;  // the side with more of it counts
      (side > 0 ? piece.front : piece.back) = share;
      if (!sheet) piece.back = 0.0;
      if (weight > 0.0)
        for (std::size_t r = 0; r < rays.size(); ++r)
          reached_(row, rays[r].first) = static_cast<std::uint8_t>(std::lround(255.0 * seen[r] / weight));
    }
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
      reached_.row(static_cast<Eigen::Index>(kept)) = reached_.row(static_cast<Eigen::Index>(i));
      ++kept;
    }
    prepared_.mesh.triangles.resize(kept);
    prepared_.part.resize(kept);
    prepared_.lid.resize(kept);
    pieces_.resize(kept);
    reached_.conservativeResize(static_cast<Eigen::Index>(kept), Eigen::NoChange);
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
  Preparation prepared_;
  Scene scene_;
  std::vector<int> samples_;  ///< points on every triangle
  Sphere sphere_;
  double rim_ = 0.0;
  int bodies_ = 0;
  std::vector<WettedPiece> pieces_;
  Eigen::Array<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic> reached_;
  Pairs pairs_;  ///< of parts that touch
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
  if (prepared.mesh.triangles.empty() || (prepared.parts() == 1 && Surface(prepared).convex)) {
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
