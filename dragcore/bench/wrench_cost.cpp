// What one wrench() costs, in double and in single precision, beside the loop that textbooks have: note's law, vertices by index, single
// precision, no checks. One thread, nanoseconds per triangle (per call for the cube); best of nine runs. Markdown table on stdout.
// `wrench_cost TARGET` forces an instruction set: AVX3 (AVX-512), AVX2, SSE4.

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <dragcore/drag.hpp>
#include <dragcore/shapes.hpp>
#include <functional>
#include <string>
#include <vector>

#include "kernels/wrench_kernel.hpp"

using namespace dragcore;
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

struct Indexed {
  std::vector<Vector3f> vertices;
  std::vector<Eigen::Vector3i> triangles;
};

/// Force and torque of the note's law, as one writes it down first.
std::pair<Vector3f, Vector3f> textbook(const Indexed& mesh, const Vector3f& velocity, const Vector3f& spin, float density) {
  Vector3f force = Vector3f::Zero(), torque = Vector3f::Zero();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3f &a = mesh.vertices[static_cast<std::size_t>(t[0])], &b = mesh.vertices[static_cast<std::size_t>(t[1])],
                   &c = mesh.vertices[static_cast<std::size_t>(t[2])];
    const Vector3f cross = (b - a).cross(c - a), place = (a + b + c) / 3.0f, u = -velocity - spin.cross(place);
    const float twice_area = cross.norm(), speed = u.norm(), w = -u.dot(cross) / twice_area;
    if (!(w > 0.0f)) continue;
    const float cosine = w / speed;
    const Vector3f push = -0.25f * density * speed * speed * cosine * cosine * (2.0f - cosine) * cross;
    force += push;
    torque += place.cross(push);
  }
  return {force, torque};
}

}  // namespace

int main(int count, char** words) {
  if (count > 1) kernels::force_target(words[1]);
  std::printf(
      "Kernels for %s.\n\n| body | motion | textbook | model | double | single | double / single | textbook / single |\n"
      "|---|---|---|---|---|---|---|---|\n",
      count > 1 ? words[1] : kernels::targets().front().c_str());
  double sink = 0.0;  // so that nothing is optimised away
  for (const auto& [name, shape, divisions] : {std::tuple<const char*, Shape, int>{"ball", Sphere{}, 16},
                                               {"ball", Sphere{}, 40},
                                               {"sheet", Plate{.chord = 1.0, .span = 1.0, .thickness = 0.0}, 40},
                                               {"cube, a call", Box{}, 1}}) {
    const TriangleMesh mesh = triangulate(shape, divisions);
    const Surface surface(mesh);
    Indexed indexed{.vertices = {}, .triangles = mesh.triangles};
    for (const Eigen::Vector3d& vertex : mesh.vertices) indexed.vertices.push_back(vertex.cast<float>());
    const bool whole = surface.size() < 100;
    const double unit = whole ? 1.0 : static_cast<double>(surface.size());
    const std::string body = whole ? std::string(name) : std::string(name) + ", " + std::to_string(surface.size());
    for (const bool spins : {false, true}) {
      Motion motion{.velocity = {-10, -1, -2}};
      if (spins) motion.angular_velocity = {3, 2, 1};
      const double loop = nanoseconds([&] {
                            sink += textbook(indexed, motion.velocity.cast<float>(), motion.angular_velocity.cast<float>(), 1.2f).first.x();
                          }) /
                          unit;
      Model plain = model_for(surface);
      plain.pillow = {};
      for (const auto& [label, chosen] :
           {std::pair<const char*, Model>{"note", Model{}}, {"by class", plain}, {"by class, pillow", model_for(surface)}}) {
        Model exact = chosen, fast = chosen;
        exact.precision = Precision::full, fast.precision = Precision::single;
        const double full = nanoseconds([&] { sink += wrench(surface, motion, {}, exact).total().force.x(); }) / unit;
        const double single = nanoseconds([&] { sink += wrench(surface, motion, {}, fast).total().force.x(); }) / unit;
        std::printf("| %s | %s | %.1f | %s | %.1f | %.2f | %.1f | %.1f |\n", body.c_str(), spins ? "spins, 3 points" : "straight", loop,
                    label, full, single, full / single, loop / single);
      }
    }
  }
  if (sink == 42.0) std::printf("\n");
}
