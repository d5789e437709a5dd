// What the air on a deforming mesh costs: a flag that waves, forces at its vertices. Nanoseconds per triangle, best of nine runs; markdown
// table on stdout. Timed is, on every side, all that a step needs once positions and velocities are where the code at hand keeps them:
//   dragcore  DeformingMesh::forces() with the note's law and with that of sheets, which rubs: areas, normals, forces, written to vertices
//   textbook  the note's law over indexed vertices in single precision, added up at the corners, which are cleared first; no checks
//   Bullet    btSoftBody: updateNormals() and addAeroForceToFace() of F_TwoSidedLiftDrag, drag alone, for every face, its nodes' forces
//             cleared first; it takes areas as they were at rest. Left out where the library is not installed
// `deforming_cost TARGET` forces an instruction set: AVX3 (AVX-512), AVX2, SSE4.

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <dragcore/deforming.hpp>
#include <functional>
#include <string>
#include <vector>

#include "kernels/wrench_kernel.hpp"

#ifdef WITH_BULLET
#include <BulletSoftBody/btSoftBody.h>
#endif
#ifdef WITH_THREADS
#include <tbb/task_arena.h>
#endif

using Eigen::Vector3f;

namespace {

double nanoseconds(const std::function<void()>& work) {
  using Clock = std::chrono::steady_clock;
  double best = 1e9;
  for (int run = 0; run < 9; ++run) {
    int calls = 0;
    double seconds = 0.0;
    for (const Clock::time_point began = Clock::now(); seconds < 0.02; ++calls) {
      work();
      seconds = std::chrono::duration<double>(Clock::now() - began).count();
    }
    best = std::min(best, seconds / calls);
  }
  return 1e9 * best;
}

void on_threads([[maybe_unused]] int count, const std::function<void()>& work) {
#ifdef WITH_THREADS
  tbb::task_arena(count).execute(work);
#else
  work();
#endif
}

/// n x n squares of two triangles each, 1 m wide.
struct Flag {
  std::vector<Eigen::Vector3i> triangles;
  std::vector<Vector3f> position, velocity;
  Eigen::Vector3d wind{8.0, 1.0, 3.0};

  explicit Flag(int n) {
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) {
        const float x = static_cast<float>(i) / static_cast<float>(n), y = static_cast<float>(j) / static_cast<float>(n);
        position.emplace_back(x, y, 0.1f * std::sin(12.0f * x + 3.0f * y));
        velocity.emplace_back(0.2f * y, 0.0f, 1.2f * std::cos(12.0f * x + 3.0f * y));
      }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const int corner = i * (n + 1) + j, next = corner + n + 1;
        triangles.emplace_back(corner, next, next + 1);
        triangles.emplace_back(corner, next + 1, corner + 1);
      }
  }
};

/// Both sides of every triangle by the note's law, as one writes it down first.
void textbook(const Flag& flag, float density, std::vector<Vector3f>& force) {
  std::fill(force.begin(), force.end(), Vector3f::Zero());
  const Vector3f wind = flag.wind.cast<float>();
  for (const Eigen::Vector3i& t : flag.triangles) {
    const auto a = static_cast<std::size_t>(t[0]), b = static_cast<std::size_t>(t[1]), c = static_cast<std::size_t>(t[2]);
    const Vector3f cross = (flag.position[b] - flag.position[a]).cross(flag.position[c] - flag.position[a]);
    const Vector3f u = wind - (flag.velocity[a] + flag.velocity[b] + flag.velocity[c]) / 3.0f;
    const float twice_area = cross.norm(), speed = u.norm();
    if (!(twice_area > 0.0f && speed > 0.0f)) continue;
    const float w = u.dot(cross) / twice_area, cosine = std::abs(w) / speed;
    const Vector3f share = std::copysign(density * speed * speed * cosine * cosine * (2.0f - cosine) / 12.0f, w) * cross;
    force[a] += share, force[b] += share, force[c] += share;
  }
}

#ifdef WITH_BULLET
btVector3 to_bullet(const Vector3f& v) { return {v.x(), v.y(), v.z()}; }

class BulletFlag {
 public:
  BulletFlag(const Flag& flag, float density) : soft_(&world_, 0, nullptr, nullptr) {
    world_.air_density = density;
    for (std::size_t v = 0; v < flag.position.size(); ++v) {
      soft_.appendNode(to_bullet(flag.position[v]), 1.0f);
      soft_.m_nodes[soft_.m_nodes.size() - 1].m_v = to_bullet(flag.velocity[v]);
    }
    for (const Eigen::Vector3i& t : flag.triangles) soft_.appendFace(t[0], t[1], t[2]);
    soft_.m_cfg.aeromodel = btSoftBody::eAeroModel::F_TwoSidedLiftDrag;
    soft_.m_cfg.kDG = 1.0f, soft_.m_cfg.kLF = 0.0f;
    soft_.m_sst.sdt = 1.0f / 60.0f;
  }
  float step(const btVector3& wind) {
    for (int i = 0; i < soft_.m_nodes.size(); ++i) soft_.m_nodes[i].m_f.setZero();
    soft_.updateNormals();
    for (int i = 0; i < soft_.m_faces.size(); ++i) soft_.addAeroForceToFace(wind, i);
    return soft_.m_nodes[0].m_f.x();
  }

 private:
  btSoftBodyWorldInfo world_;
  btSoftBody soft_;
};
#endif

}  // namespace

int main(int count, char** words) {
  using namespace dragcore;
  if (count > 1) kernels::force_target(words[1]);
  std::printf(
      "Kernels for %s.\n\n| triangles | dragcore, note | dragcore, sheet | the same, 2 threads | textbook | Bullet | textbook / note | "
      "Bullet / note | Bullet / sheet |\n|---|---|---|---|---|---|---|---|---|\n",
      count > 1 ? words[1] : kernels::targets().front().c_str());
  const Medium medium{.density = 1.2};
  for (const int n : {22, 71, 224, 707}) {
    const Flag flag(n);
    const double faces = static_cast<double>(flag.triangles.size());
    DeformingMesh mesh(flag.triangles, flag.position.size(), Surface::Sides::two);
    std::vector<Vector3f> force(flag.position.size()), plain(force);
    const auto ours = [&](const Law& law) { mesh.forces(flag.position, flag.velocity, flag.wind, medium, law, force); };
    double note = 0.0, sheet = 0.0, shared = 0.0, bullet = std::nan("");
    const Law smooth = note_law(), rubs = sheet_law();
    on_threads(1, [&] { note = nanoseconds([&] { ours(smooth); }) / faces; });
    const double loop = nanoseconds([&] { textbook(flag, 1.2f, plain); }) / faces;
    // Of single precision, of 50 Pa on what is a vertex's, where the flow is nearly along it.
    const float least = 1e-5f * 50.0f / static_cast<float>(n * n);
    for (std::size_t v = 0; v < force.size(); ++v)
      if (!((force[v] - plain[v]).norm() <= least + 1e-4f * plain[v].norm())) {
        std::printf("\nvertex %zu: dragcore and the textbook differ\n", v);
        return 1;
      }
    on_threads(1, [&] { sheet = nanoseconds([&] { ours(rubs); }) / faces; });
    on_threads(2, [&] { shared = nanoseconds([&] { ours(rubs); }) / faces; });
#ifdef WITH_BULLET
    BulletFlag soft(flag, 1.2f);
    const btVector3 wind = to_bullet(flag.wind.cast<float>());
    float sink = 0.0f;  // so that nothing is optimised away
    bullet = nanoseconds([&] { sink += soft.step(wind); }) / faces;
    if (!std::isfinite(sink)) return 1;
#endif
    std::printf("| %.0f | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f |\n", faces, note, sheet, shared, loop, bullet, loop / note,
                bullet / note, bullet / sheet);
    std::fflush(stdout);
  }
}
