// A square sheet that deforms, in dragcore and in Bullet: new places of all vertices, and from them a force on every face.

#include <tbb/task_arena.h>

#include <dragcore/deforming.hpp>

#include "compare/peers/peers.hpp"
#include "dragcore/bench/rows.hpp"

using namespace dragcore;

namespace {

/// A wave runs through the sheet: its places at two instants, in turn.
struct Waving {
  explicit Waving(int faces) : sheet(bench::body("sheet-" + std::to_string(faces)).mesh), other(sheet) {
    for (Eigen::Vector3d& vertex : sheet.vertices) vertex.z() += 0.02 * std::sin(9.0 * vertex.x());
    for (Eigen::Vector3d& vertex : other.vertices) vertex.z() += 0.02 * std::cos(9.0 * vertex.x());
  }
  const TriangleMesh& next() { return ++frame % 2 ? other : sheet; }

  TriangleMesh sheet, other;
  int frame = 0;
};

void add_deforming_rows(int faces) {
  const Motion motion = bench::motion("straight");
  const auto finish = [=](benchmark::State& state, const Wrench& total) {
    bench::count(state, faces);
    state.SetLabel(bench::Hash().add(total).text());
    if (!(total.force.dot(motion.velocity) < 0.0)) bench::wrong(state, "the force does not hold the sheet back");
  };
  for (const int threads : {1, 2})
    bench::add_row("deforming/dragcore/" + std::to_string(faces) + (threads > 1 ? "/threads:2" : ""),
                   [=](benchmark::State& state) {
                     Waving waving(faces);
                     DeformingMesh mesh(waving.sheet.triangles, waving.sheet.vertices.size(), Surface::Sides::two);
                     // An engine keeps its vertices in single precision.
                     const auto vertices = [](const TriangleMesh& given) {
                       std::vector<Eigen::Vector3f> result;
                       for (const Eigen::Vector3d& vertex : given.vertices) result.push_back(vertex.cast<float>());
                       return result;
                     };
                     const std::vector<Eigen::Vector3f> one = vertices(waving.sheet), other = vertices(waving.other),
                                                        velocity(one.size(), motion.velocity.cast<float>());
                     std::vector<Eigen::Vector3f> force(one.size());
                     bool turn = false;
                     tbb::task_arena arena(threads);
                     for (auto _ : state)
                       arena.execute([&] { mesh.forces((turn = !turn) ? other : one, velocity, motion.wind, {}, note_law(), force); });
                     Wrench total;
                     for (const Eigen::Vector3f& each : force) total.force += each.cast<double>();
                     finish(state, total);
                   })
        ->UseRealTime()
        ->Unit(benchmark::kMicrosecond);
  bench::add_row("deforming/bullet/" + std::to_string(faces), [=](benchmark::State& state) {
    Waving waving(faces);
    peers::BulletMesh bullet(waving.sheet);
    for (auto _ : state) {
      bullet.move_to(waving.next().vertices);
      bullet.aerodynamic_forces(motion.velocity);
    }
    finish(state, bullet.total());
  })->Unit(benchmark::kMicrosecond);
}

}  // namespace

int main(int count, char** words) {
  benchmark::Initialize(&count, words);
  benchmark::AddCustomContext("instruction_set", "best");
  for (const int faces : {1058, 10082, 100352}) add_deforming_rows(faces);  // 2 n^2
  const bool some = benchmark::RunSpecifiedBenchmarks() > 0;
  return some && !bench::any_wrong ? 0 : 1;
}
