#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <dragcore/preparation.hpp>
#include <functional>
#include <limits>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <unordered_map>

#include "body/edges.hpp"
#include "body/extents.hpp"

namespace dragcore {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

double area_of(const TriangleMesh& mesh, const Vector3i& t) {
  const Vector3d a = mesh.vertices[t[0]];
  return 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).stableNorm();
}

std::string number(double value) {
  std::ostringstream text;
  text.precision(4);
  text << value;
  return text.str();
}

std::string plural(int count, const std::string& one, const std::string& many = "") {
  return std::to_string(count) + " " + (count == 1 ? one : many.empty() ? one + "s" : many);
}

bool has_repeated_corner(const Vector3i& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

struct OpenEdges {
  int boundary = 0, non_manifold = 0;
  std::vector<bool> at_vertex;  ///< on a boundary edge
};

OpenEdges open_edges(const TriangleMesh& mesh) {
  OpenEdges found{.at_vertex = std::vector<bool>(mesh.vertices.size(), false)};
  EdgeTable(mesh.triangles).for_each([&](std::span<const EdgeUse> uses) {
    if (uses.size() == 1) {
      ++found.boundary;
      found.at_vertex[static_cast<std::size_t>(uses[0].low)] = found.at_vertex[static_cast<std::size_t>(uses[0].high)] = true;
    }
    if (uses.size() > 2) ++found.non_manifold;
  });
  return found;
}

/// Joins vertices on open edges that lie within `relative` of the shortest edge at either of them, or within four steps of single
/// precision.
/// @return the number of vertices that went, 0 when nothing lies that close
int join_corners(TriangleMesh& mesh, const OpenEdges& open, double relative) {
  const std::size_t count = mesh.vertices.size();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> shortest(count, infinity), around(count, infinity);  // edge at every vertex; longest edge of a triangle there
  for (const Vector3i& t : mesh.triangles) {
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
      const int from = t[k], to = t[(k + 1) % 3];
      const double length = (mesh.vertices[from] - mesh.vertices[to]).norm();
      longest = std::max(longest, length);
      if (from != to) shortest[from] = std::min(shortest[from], length), shortest[to] = std::min(shortest[to], length);
    }
    for (const int corner : t) around[corner] = std::min(around[corner], longest);
  }
  std::vector<double> reach(count, 0.0);
  Vector3d low = Vector3d::Constant(infinity);
  double least = infinity, most = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!open.at_vertex[i] || !std::isfinite(shortest[i])) continue;
    low = low.cwiseMin(mesh.vertices[i]);
    // A needle's short edge must not keep its corners from their neighbours: the step of the coordinates is what files are rounded to. Far
    // from the origin that step may be as long as the triangles are: a quarter of them is no rounding.
    const double step = 4.0 * std::numeric_limits<float>::epsilon() * mesh.vertices[i].cwiseAbs().maxCoeff();
    reach[i] = std::max(relative * shortest[i], std::min(step, 0.25 * around[i]));
    if (reach[i] > 0.0) least = std::min(least, reach[i]), most = std::max(most, reach[i]);
  }
  if (!(most > 0.0)) return 0;

  // Neighbours by a hash of cells; a collision only costs a comparison. Two vertices are joined within the smaller of their reaches: cells
  // of many sizes, each with those alone that reach as far, so that one huge triangle does not put all others into one cell.
  using Cell = Eigen::Matrix<std::int64_t, 3, 1>;
  const auto hash = [](const Cell& c) {
    return static_cast<std::uint64_t>(c[0]) * 0x9E3779B97F4A7C15ull ^ static_cast<std::uint64_t>(c[1]) * 0xC2B2AE3D27D4EB4Full ^
           static_cast<std::uint64_t>(c[2]) * 0x165667B19E3779F9ull;
  };
  constexpr double coarser = 8.0;
  DisjointSets sets(count);
  for (double size = least, reached = 0.0; reached < most; reached = size, size *= coarser) {
    const auto cell_of = [&](const Vector3d& v) -> Cell {
      return ((v - low) / size).array().min(1e15).floor().cast<std::int64_t>().matrix();
    };
    std::unordered_map<std::uint64_t, std::vector<int>> cells;
    for (std::size_t i = 0; i < count; ++i)
      if (reach[i] > reached) cells[hash(cell_of(mesh.vertices[i]))].push_back(static_cast<int>(i));
    for (std::size_t i = 0; i < count; ++i) {
      if (!(reach[i] > reached)) continue;
      const Cell home = cell_of(mesh.vertices[i]);
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
          for (int z = -1; z <= 1; ++z) {
            const auto entry = cells.find(hash(home + Cell(x, y, z)));
            if (entry == cells.end()) continue;
            for (const int other : entry->second)
              if (other > static_cast<int>(i) &&
                  (mesh.vertices[other] - mesh.vertices[i]).norm() <= std::min(reach[i], reach[static_cast<std::size_t>(other)]))
                sets.join(static_cast<int>(i), other);
          }
    }
  }
  int gone = 0;
  for (std::size_t i = 0; i < count; ++i) gone += sets.root(static_cast<int>(i)) != static_cast<int>(i);
  for (Vector3i& t : mesh.triangles)
    for (int& corner : t) corner = sets.root(corner);
  return gone;
}

/// Leaves out triangles with a repeated corner, and all but the first of those with the same three corners.
void drop_repeated(TriangleMesh& mesh, std::vector<Finding>& report) {
  std::vector<std::pair<std::array<int, 3>, int>> sorted;
  sorted.reserve(mesh.triangles.size());
  int degenerate = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vector3i& t = mesh.triangles[i];
    if (is_degenerate(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]])) ++degenerate;
    if (has_repeated_corner(t)) continue;
    std::array<int, 3> key{t[0], t[1], t[2]};
    std::sort(key.begin(), key.end());
    sorted.emplace_back(key, static_cast<int>(i));
  }
  sort_by_buckets(
      sorted, mesh.vertices.size(), [](const auto& entry) { return entry.first[0]; }, std::less<>());
  std::vector<bool> keep(mesh.triangles.size(), false);
  int duplicates = 0;
  double area = 0.0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i == 0 || sorted[i].first != sorted[i - 1].first) {
      keep[static_cast<std::size_t>(sorted[i].second)] = true;
    } else {
      ++duplicates;
      area += area_of(mesh, mesh.triangles[static_cast<std::size_t>(sorted[i].second)]);
    }
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    if (keep[i]) mesh.triangles[kept++] = mesh.triangles[i];
  mesh.triangles.resize(kept);
  if (degenerate > 0)
    report.push_back({Finding::Kind::degenerate, degenerate, 0.0, plural(degenerate, "triangle") + " without area: no force"});
  if (duplicates > 0)
    report.push_back({Finding::Kind::duplicate, duplicates, area,
                      plural(duplicates, "triangle") + " said more than once (" + number(area) + " m^2): each counts once"});
}

/// Of several tolerances the smallest that leaves the fewest open edges. Edges of three triangles are made where bodies touch or a fin
/// stands on one; more of them than a quarter of the open edges that go say that what was joined does not belong together.
void weld(TriangleMesh& mesh, std::vector<Finding>& report) {
  const OpenEdges before = open_edges(mesh);
  if (before.boundary == 0) return;
  int fewest = before.boundary, joined = 0;
  TriangleMesh best;
  for (const double relative : {0.0, 1e-5, 1e-4, 1e-3}) {
    TriangleMesh attempt = mesh;
    const int gone = join_corners(attempt, before, relative);
    if (gone == 0) continue;
    TriangleMesh once = attempt;  // said twice and joined, a triangle makes an edge of three that goes with the repeat
    std::vector<Finding> unsaid;
    drop_repeated(once, unsaid);
    const OpenEdges after = open_edges(once);
    if (after.boundary < fewest && 4 * (after.non_manifold - before.non_manifold) <= before.boundary - after.boundary) {
      fewest = after.boundary;
      joined = gone;
      best = std::move(attempt);
    }
    if (fewest == 0) break;
  }
  if (joined == 0) return;
  mesh = std::move(best);
  report.push_back(
      {Finding::Kind::welded, joined, 0.0,
       plural(joined, "corner") + " joined with others a hair away, which closed " + plural(before.boundary - fewest, "open edge")});
}

/// Which triangle goes on behind each edge of every triangle (-1: none), and whether its winding agrees.
struct Links {
  struct Link {
    int neighbour = -1;
    bool agrees = true;
  };
  std::vector<std::array<Link, 3>> of;
  int non_manifold = 0;
};

Links link_triangles(const TriangleMesh& mesh) {
  Links links{.of = std::vector<std::array<Links::Link, 3>>(mesh.triangles.size())};
  const auto slot = [&](const EdgeUse& use) -> Links::Link& {
    const Vector3i& t = mesh.triangles[static_cast<std::size_t>(use.triangle)];
    const int from = use.forward ? use.low : use.high, to = use.forward ? use.high : use.low;
    for (int k = 0; k < 3; ++k)
      if (t[k] == from && t[(k + 1) % 3] == to) return links.of[static_cast<std::size_t>(use.triangle)][static_cast<std::size_t>(k)];
    throw std::logic_error("preparation: an edge is not of its triangle");
  };
  const auto join = [&](const EdgeUse& a, const EdgeUse& b) {
    slot(a) = {b.triangle, a.forward != b.forward};
    slot(b) = {a.triangle, a.forward != b.forward};
  };
  EdgeTable(mesh.triangles).for_each([&](std::span<const EdgeUse> uses) {
    if (uses.size() == 2) join(uses[0], uses[1]);
    if (uses.size() < 3) return;
    ++links.non_manifold;
    // Pairs that turn least come first; of two that turn alike the convex one, so that two boxes on one edge stay two boxes.
    const Vector3d from = mesh.vertices[uses[0].low], axis = (mesh.vertices[uses[0].high] - from).stableNormalized();
    const auto wing = [&](const EdgeUse& use) -> Vector3d {
      const Vector3i& t = mesh.triangles[static_cast<std::size_t>(use.triangle)];
      const int tip = t[0] + t[1] + t[2] - use.low - use.high;
      const Vector3d arm = mesh.vertices[tip] - from;
      return (arm - axis * axis.dot(arm)).stableNormalized();
    };
    struct Pair {
      double turn;
      std::size_t a, b;
    };
    std::vector<Pair> pairs;
    for (std::size_t a = 0; a < uses.size(); ++a)
      for (std::size_t b = a + 1; b < uses.size(); ++b) {
        if (uses[a].forward == uses[b].forward) continue;
        const EdgeUse &forward = uses[a].forward ? uses[a] : uses[b], &backward = uses[a].forward ? uses[b] : uses[a];
        const Vector3d u = wing(forward), v = wing(backward);
        const double turn = std::acos(std::clamp(-u.dot(v), -1.0, 1.0));
        const bool concave = axis.cross(u).dot(v) > 0.0;  // the second rises above the first, seen from outside
        pairs.push_back({turn + (concave ? 1e-6 : 0.0), a, b});
      }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.turn < b.turn; });
    std::vector<bool> taken(uses.size(), false);
    for (const Pair& pair : pairs)
      if (!taken[pair.a] && !taken[pair.b]) {
        join(uses[pair.a], uses[pair.b]);
        taken[pair.a] = taken[pair.b] = true;
      }
  });
  return links;
}

/// A connected part of the mesh while it is being prepared.
struct Shell {
  std::vector<int> triangles;
  std::vector<Vector3i> lids;
  std::vector<int> lid_loop;  ///< which hole each lid closes
  double area = 0.0;          ///< without lids
  double volume = 0.0;        ///< with lids, of the triangles as wound
  bool sheet = false, hidden = false;
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
};

/// Whether a ray meets a triangle ahead of its origin. An edge hit counts as a hit or not by rounding: callers ask more than once.
bool ray_hits(const Vector3d& origin, const Vector3d& direction, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, p = direction.cross(ac);
  const double determinant = ab.dot(p);
  if (determinant == 0.0) return false;
  const Vector3d s = origin - a, q = s.cross(ab);
  const double u = s.dot(p) / determinant, v = direction.dot(q) / determinant;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) / determinant > 0.0;
}

class Preparer {
 public:
  explicit Preparer(const TriangleMesh& given) {
    validate(given);
    mesh_ = welded(given);
    weld(mesh_, report_);
    drop_repeated(mesh_, report_);
    wind();
    for (Shell& shell : shells_) close(shell);
    hide();
  }

  Preparation result() {
    Preparation prepared;
    std::vector<int> part_of_shell(shells_.size(), -1);
    std::vector<std::vector<std::size_t>> lids_of(shells_.size());
    double sheet_area = 0.0;
    int sheets = 0;
    for (std::size_t s = 0; s < shells_.size(); ++s) {
      if (shells_[s].hidden) continue;
      part_of_shell[s] = prepared.parts();
      prepared.sheet.push_back(shells_[s].sheet);
      if (shells_[s].sheet) ++sheets, sheet_area += shells_[s].area;
    }
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      const int part = part_of_shell[static_cast<std::size_t>(shell_of_[i])];
      if (part < 0) continue;
      prepared.mesh.triangles.push_back(mesh_.triangles[i]);
      prepared.part.push_back(part);
      prepared.lid.push_back(false);
    }
    for (std::size_t s = 0; s < shells_.size(); ++s)
      if (part_of_shell[s] >= 0)
        for (const Vector3i& lid : shells_[s].lids) {
          prepared.mesh.triangles.push_back(lid);
          prepared.part.push_back(part_of_shell[s]);
          prepared.lid.push_back(true);
        }
    prepared.mesh.vertices = std::move(mesh_.vertices);
    drop_unused_vertices(prepared.mesh);
    if (sheets > 0 && sheets < static_cast<int>(shells_.size()))
      report_.push_back({Finding::Kind::sheet, sheets, sheet_area,
                         plural(sheets, "sheet") + " (" + number(sheet_area) + " m^2) beside bodies: both sides feel the air"});
    prepared.report = merged(report_);
    return prepared;
  }

 private:
  /// One finding of each kind, in the order in which they first occur: a tower of hundreds of open shells is one line, not hundreds.
  static std::vector<Finding> merged(const std::vector<Finding>& findings) {
    std::vector<Finding> report;
    for (const Finding& finding : findings) {
      const auto same = std::find_if(report.begin(), report.end(), [&](const Finding& other) { return other.kind == finding.kind; });
      if (same == report.end()) {
        report.push_back(finding);
        continue;
      }
      same->count += finding.count;
      same->area += finding.area;
      const std::string area = " (" + number(same->area) + " m^2)";
      switch (finding.kind) {
        case Finding::Kind::inside_out:
          same->text = plural(same->count, "shell") + area + " whose normals point inwards: turned";
          break;
        case Finding::Kind::capped:
          same->text = plural(same->count, "hole") + area + " of bodies closed by lids that feel the wind";
          break;
        case Finding::Kind::open_through:
          same->text = plural(same->count, "shell") + area + " that one can look through: left open, both sides feel the air";
          break;
        default:
          break;  // said once only
      }
    }
    return report;
  }

  std::array<Vector3d, 3> corners(const Vector3i& t) const { return {mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]}; }
  Vector3i& triangle(int i) { return mesh_.triangles[static_cast<std::size_t>(i)]; }

  static void drop_unused_vertices(TriangleMesh& mesh) {
    std::vector<int> renumbered(mesh.vertices.size(), -1);
    for (const Vector3i& t : mesh.triangles)
      for (const int corner : t) renumbered[static_cast<std::size_t>(corner)] = 0;
    int count = 0;
    for (std::size_t i = 0; i < renumbered.size(); ++i)
      if (renumbered[i] == 0) {
        mesh.vertices[static_cast<std::size_t>(count)] = mesh.vertices[i];
        renumbered[i] = count++;
      }
    mesh.vertices.resize(static_cast<std::size_t>(count));
    for (Vector3i& t : mesh.triangles)
      for (int& corner : t) corner = renumbered[static_cast<std::size_t>(corner)];
  }

  /// Shells, and one winding within each: the one that most of its area has.
  void wind() {
    links_ = link_triangles(mesh_);
    if (links_.non_manifold > 0)
      report_.push_back(
          {Finding::Kind::non_manifold, links_.non_manifold, 0.0, plural(links_.non_manifold, "edge") + " of more than two triangles"});
    const std::size_t count = mesh_.triangles.size();
    shell_of_.assign(count, -1);
    std::vector<char> turned(count, 0);
    int reversed = 0;
    double reversed_area = 0.0;
    for (std::size_t first = 0; first < count; ++first) {
      if (shell_of_[first] >= 0) continue;
      Shell shell;
      const int id = static_cast<int>(shells_.size());
      shell_of_[first] = id;
      shell.triangles.push_back(static_cast<int>(first));
      double turned_area = 0.0;
      int turned_count = 0;
      for (std::size_t k = 0; k < shell.triangles.size(); ++k) {
        const auto t = static_cast<std::size_t>(shell.triangles[k]);
        const double area = area_of(mesh_, mesh_.triangles[t]);
        shell.area += area;
        if (turned[t]) turned_area += area, ++turned_count;
        for (const Links::Link& link : links_.of[t]) {
          if (link.neighbour < 0 || shell_of_[static_cast<std::size_t>(link.neighbour)] >= 0) continue;
          shell_of_[static_cast<std::size_t>(link.neighbour)] = id;
          turned[static_cast<std::size_t>(link.neighbour)] = turned[t] != (link.agrees ? 0 : 1);
          shell.triangles.push_back(link.neighbour);
        }
      }
      const bool most = turned_area > 0.5 * shell.area;
      for (const int t : shell.triangles)
        if ((turned[static_cast<std::size_t>(t)] != 0) != most) turn(t);
      reversed += most ? static_cast<int>(shell.triangles.size()) - turned_count : turned_count;
      reversed_area += most ? shell.area - turned_area : turned_area;
      shell.triangles.clear();
      shells_.push_back(std::move(shell));
    }
    for (std::size_t t = 0; t < count; ++t) shells_[static_cast<std::size_t>(shell_of_[t])].triangles.push_back(static_cast<int>(t));
    if (reversed > 0)
      report_.push_back({Finding::Kind::reversed, reversed, reversed_area,
                         plural(reversed, "triangle") + " (" + number(reversed_area) + " m^2) wound against their neighbours: turned"});
  }

  void turn(int t) {
    std::swap(triangle(t)[1], triangle(t)[2]);
    auto& links = links_.of[static_cast<std::size_t>(t)];  // edges in the new order: 0-1 was 2-0, and 2-0 was 0-1
    std::swap(links[0], links[2]);
  }

  /// Closed loops of directed edges without a neighbour, each as its vertices in the order of the winding.
  std::vector<std::vector<int>> loops(const Shell& shell) {
    std::unordered_map<int, std::vector<int>> next;
    std::vector<int> starts;
    for (const int i : shell.triangles)
      for (int k = 0; k < 3; ++k)
        if (links_.of[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)].neighbour < 0) {
          next[triangle(i)[k]].push_back(triangle(i)[(k + 1) % 3]);
          starts.push_back(triangle(i)[k]);
        }
    std::vector<std::vector<int>> found;
    for (const int start : starts) {
      if (next[start].empty()) continue;
      std::vector<int> loop;
      int at = start;
      do {
        loop.push_back(at);
        auto& ways = next[at];
        const int to = ways.back();
        ways.pop_back();
        at = to;
      } while (at != start && !next[at].empty());
      if (loop.size() >= 3) found.push_back(std::move(loop));
    }
    return found;
  }

  double tetrahedra(const std::vector<Vector3i>& triangles, const Vector3d& origin) const {
    double sum = 0.0;
    for (const Vector3i& t : triangles) {
      const auto p = corners(t);
      sum += (p[0] - origin).dot((p[1] - origin).cross(p[2] - origin)) / 6.0;
    }
    return sum;
  }

  /// Lids on the holes, a winding that points outwards, and whether the shell is a sheet.
  void close(Shell& shell) {
    std::vector<Vector3i> own;
    for (const int i : shell.triangles) {
      own.push_back(triangle(i));
      for (const Vector3d& corner : corners(triangle(i))) shell.low = shell.low.cwiseMin(corner), shell.high = shell.high.cwiseMax(corner);
    }
    const Vector3d origin = 0.5 * (shell.low + shell.high);
    const std::vector<std::vector<int>> holes = loops(shell);
    const std::size_t vertices_before = mesh_.vertices.size();
    double lid_area = 0.0;
    for (std::size_t h = 0; h < holes.size(); ++h) {
      Vector3d centre = Vector3d::Zero();
      for (const int v : holes[h]) centre += mesh_.vertices[static_cast<std::size_t>(v)];
      const int hub = static_cast<int>(mesh_.vertices.size());
      if (holes[h].size() > 3) mesh_.vertices.push_back(centre / static_cast<double>(holes[h].size()));
      const auto add = [&](const Vector3i& lid) {
        const auto p = corners(lid);
        if (is_degenerate(p[0], p[1], p[2])) return;
        shell.lids.push_back(lid);
        shell.lid_loop.push_back(static_cast<int>(h));
        lid_area += area_of(mesh_, lid);
      };
      if (holes[h].size() == 3)
        add({holes[h][0], holes[h][2], holes[h][1]});
      else
        for (std::size_t k = 0; k < holes[h].size(); ++k) add({hub, holes[h][(k + 1) % holes[h].size()], holes[h][k]});
    }
    std::vector<Vector3i> all = own;
    all.insert(all.end(), shell.lids.begin(), shell.lids.end());
    shell.volume = tetrahedra(all, origin);
    const bool was_closed = holes.empty();
    const Vector3d extents = principal_box(static_cast<Eigen::Index>(all.size()), [&](Eigen::Index i) {
                               return corners(all[static_cast<std::size_t>(i)]);
                             }).extents;
    // A plate with a crack or a triangle missing is thin, but closed all the same: a sheet has about as much hole as surface.
    const bool thin = is_sheet(shell.volume, shell.area + lid_area, extents) && lid_area > 0.2 * shell.area;
    bool through = false;
    if (!was_closed && !thin) through = one_can_look_through(shell, own, holes.size());
    if (!was_closed && (thin || through)) {
      shell.sheet = true;
      shell.lids.clear();
      mesh_.vertices.resize(vertices_before);
      if (through)
        report_.push_back({Finding::Kind::open_through, 1, shell.area,
                           "a shell of " + number(shell.area) + " m^2 that one can look through: left open, both sides feel the air"});
      return;
    }
    // Two skins at one place have no volume but rounding, and no outside.
    if (shell.volume < -1e-12 * shell.area * std::sqrt(shell.area)) {
      for (const int i : shell.triangles) turn(i);
      for (Vector3i& lid : shell.lids) std::swap(lid[1], lid[2]);
      shell.volume = -shell.volume;
      report_.push_back({Finding::Kind::inside_out, 1, shell.area,
                         "a shell of " + plural(static_cast<int>(shell.triangles.size()), "triangle") + " (" + number(shell.area) +
                             " m^2) whose normals point inwards: turned"});
    }
    if (!holes.empty())
      report_.push_back(
          {Finding::Kind::capped, static_cast<int>(holes.size()), lid_area,
           plural(static_cast<int>(holes.size()), "hole") + " (" + number(lid_area) + " m^2) of a body closed by lids that feel the wind"});
  }

  /// Whether holes that make up half of the view along their normal have no wall behind them. Small holes through a body are none.
  bool one_can_look_through(const Shell& shell, const std::vector<Vector3i>& own, std::size_t holes) const {
    std::vector<Vector3d> area_vector(holes, Vector3d::Zero());
    for (std::size_t k = 0; k < shell.lids.size(); ++k) {
      const auto p = corners(shell.lids[k]);
      area_vector[static_cast<std::size_t>(shell.lid_loop[k])] += 0.5 * (p[1] - p[0]).cross(p[2] - p[0]);
    }
    for (std::size_t h = 0; h < holes; ++h) {
      const double size = area_vector[h].norm();
      if (size < 0.02 * shell.area) continue;  // never half of a view: a shell's mean view is a quarter of its area
      const Vector3d normal = area_vector[h] / size;
      double view = 0.0;
      for (const Vector3i& t : own) {
        const auto p = corners(t);
        view += 0.25 * std::abs((p[1] - p[0]).cross(p[2] - p[0]).dot(normal));
      }
      for (const Vector3d& other : area_vector) view += 0.5 * std::abs(other.dot(normal));
      // Rays from points of the lid into the body, along its normal; which way is in, the volume's sign tells.
      const Vector3d inwards = shell.volume > 0.0 ? Vector3d(-normal) : normal;
      double open = 0.0;
      std::vector<std::size_t> lids;
      for (std::size_t k = 0; k < shell.lids.size(); ++k)
        if (shell.lid_loop[k] == static_cast<int>(h)) lids.push_back(k);
      const std::size_t stride = std::max<std::size_t>(1, lids.size() / 16);
      double sampled = 0.0;
      for (std::size_t k = 0; k < lids.size(); k += stride) {
        const auto p = corners(shell.lids[lids[k]]);
        const double weight = area_of(mesh_, shell.lids[lids[k]]);
        const Vector3d origin = 0.32 * p[0] + 0.35 * p[1] + 0.33 * p[2];
        const bool wall = std::any_of(own.begin(), own.end(), [&](const Vector3i& t) {
          const auto c = corners(t);
          return ray_hits(origin, inwards, c[0], c[1], c[2]);
        });
        sampled += weight;
        if (!wall) open += weight;
      }
      if (open > 0.5 * sampled && size > 0.5 * view) return true;
    }
    return false;
  }

  /// Shells wholly inside a closed one.
  void hide() {
    int hidden = 0;
    double area = 0.0;
    for (Shell& inner : shells_) {
      const double margin = 1e-9 * (inner.high - inner.low).norm();
      for (const Shell& outer : shells_) {
        if (&outer == &inner || outer.sheet || outer.hidden || !(outer.volume > 0.0)) continue;
        if ((inner.low.array() < outer.low.array() - margin).any() || (inner.high.array() > outer.high.array() + margin).any()) continue;
        if (!inner.sheet && inner.volume >= outer.volume) continue;
        if (!is_inside(inner, outer)) continue;
        inner.hidden = true;
        hidden += static_cast<int>(inner.triangles.size());
        area += inner.area;
        break;
      }
    }
    if (hidden > 0)
      report_.push_back({Finding::Kind::hidden, hidden, area,
                         plural(hidden, "triangle") + " (" + number(area) + " m^2) inside a closed shell: no wind reaches them"});
  }

  /// Up to eight of the inner triangles, spread over them, by the parity of crossings along three directions each.
  bool is_inside(const Shell& inner, const Shell& outer) const {
    const std::size_t stride = std::max<std::size_t>(1, inner.triangles.size() / 8);
    for (std::size_t k = 0; k < inner.triangles.size(); k += stride) {
      const auto p = corners(mesh_.triangles[static_cast<std::size_t>(inner.triangles[k])]);
      const Vector3d origin = 0.31 * p[0] + 0.36 * p[1] + 0.33 * p[2];
      int odd = 0;
      for (const Vector3d& direction : {Vector3d(0.813, 0.347, 0.467), Vector3d(-0.391, 0.869, -0.304), Vector3d(0.173, -0.571, -0.803)}) {
        int crossings = 0;
        const auto count = [&](const Vector3i& t) {
          const auto c = corners(t);
          crossings += ray_hits(origin, direction, c[0], c[1], c[2]);
        };
        for (const int t : outer.triangles) count(mesh_.triangles[static_cast<std::size_t>(t)]);
        for (const Vector3i& lid : outer.lids) count(lid);
        odd += crossings % 2;
      }
      if (odd < 2) return false;
    }
    return true;
  }

  TriangleMesh mesh_;
  Links links_;
  std::vector<int> shell_of_;
  std::vector<Shell> shells_;
  std::vector<Finding> report_;
};

}  // namespace

std::string to_string(Finding::Kind kind) {
  switch (kind) {
    case Finding::Kind::welded:
      return "welded";
    case Finding::Kind::degenerate:
      return "degenerate";
    case Finding::Kind::duplicate:
      return "duplicate";
    case Finding::Kind::reversed:
      return "reversed";
    case Finding::Kind::inside_out:
      return "inside out";
    case Finding::Kind::capped:
      return "capped";
    case Finding::Kind::sheet:
      return "sheet";
    case Finding::Kind::open_through:
      return "open through";
    case Finding::Kind::hidden:
      return "hidden";
    case Finding::Kind::covered:
      return "covered";
    case Finding::Kind::non_manifold:
      return "non-manifold";
    case Finding::Kind::joined:
      return "joined";
  }
  throw std::invalid_argument("not a kind of finding");
}

bool Preparation::found(Finding::Kind kind) const {
  return std::any_of(report.begin(), report.end(), [kind](const Finding& finding) { return finding.kind == kind; });
}

Preparation prepare(const TriangleMesh& mesh) { return Preparer(mesh).result(); }

std::string describe(const std::vector<Finding>& report) {
  std::string text;
  for (const Finding& finding : report) text += (text.empty() ? "" : "\n") + to_string(finding.kind) + ": " + finding.text;
  return text;
}

}  // namespace dragcore
