// What a mesh costs before its first force, step by step: processor seconds of all threads, and on the clock. Markdown table on stdout.
//   preparation_cost [10000 100000 1000000]        how many triangles, about
// The last columns tell whether a change that should change nothing did: a hash of the surface's bits, and the drag [N] in an oblique wind.

#include <sys/resource.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dragcore/drag.hpp>
#include <dragcore/expose.hpp>
#include <dragcore/mesh_file.hpp>
#include <dragcore/shapes.hpp>
#include <filesystem>
#include <string>
#include <vector>

using namespace dragcore;
using Eigen::Vector3d;

namespace {

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Prints what a step took and returns what it made.
template <class Work>
auto timed(Work&& work) {
  const double began = processor_seconds();
  const auto clock = std::chrono::steady_clock::now();
  auto result = work();
  std::printf(" %.2f (%.2f) |", processor_seconds() - began,
              std::chrono::duration<double>(std::chrono::steady_clock::now() - clock).count());
  std::fflush(stdout);
  return result;
}

/// FNV-1a, eight bytes at a time.
class Hash {
 public:
  template <class Array>
  void add(const Array& values) {
    const auto bytes = static_cast<std::size_t>(values.size()) * sizeof(*values.data());
    const char* at = reinterpret_cast<const char*>(values.data());
    for (std::size_t k = 0; k < bytes; k += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, at + k, std::min<std::size_t>(8, bytes - k));
      value_ = (value_ ^ word) * 1099511628211ull;
    }
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037ull;
};

std::uint64_t hash_of(const Surface& surface) {
  Hash hash;
  for (const Eigen::ArrayX3d* column : {&surface.normal, &surface.centroid, &surface.edge_ab, &surface.edge_ac}) hash.add(*column);
  hash.add(surface.area), hash.add(surface.back), hash.add(surface.part), hash.add(surface.patch);
  hash.add(surface.second_moment), hash.add(surface.curvature);
  if (surface.exposure) hash.add(surface.exposure->reached);
  return hash.value();
}

TriangleMesh ball(int triangles) {
  return triangulate(Sphere{1.0}, std::max(1, static_cast<int>(std::lround(std::sqrt(triangles / 8.0)))));
}

TriangleMesh dented_ball(int triangles) {
  TriangleMesh mesh = ball(triangles);
  for (Vector3d& v : mesh.vertices) v *= 1.0 - 0.5 * std::exp(-10.0 * (v / v.norm() - Vector3d::UnitX()).squaredNorm());
  return mesh;
}

/// Eight balls that overlap, and a cube and a square sheet beside them.
TriangleMesh soup(int triangles) {
  TriangleMesh all;
  const auto add = [&](const TriangleMesh& mesh, const Vector3d& by) {
    const Eigen::Vector3i offset = Eigen::Vector3i::Constant(static_cast<int>(all.vertices.size()));
    for (const Vector3d& v : mesh.vertices) all.vertices.push_back(v + by);
    for (const Eigen::Vector3i& t : mesh.triangles) all.triangles.push_back(t + offset);
  };
  for (int k = 0; k < 8; ++k) add(ball(triangles / 10), {0.8 * (k & 1), 0.8 * (k >> 1 & 1), 0.8 * (k >> 2)});
  const int divisions = std::max(1, static_cast<int>(std::lround(std::sqrt(triangles / 120.0))));
  add(triangulate(Box{}, divisions), {3, 0, 0});
  add(triangulate(Plate{1.0, 1.0, 0.0}, 2 * divisions), {0, 3, 0});
  return all;
}

}  // namespace

int main(int count, char** words) {
  std::vector<int> sizes;
  for (int k = 1; k < count; ++k) sizes.push_back(std::atoi(words[k]));
  if (sizes.empty()) sizes = {10000, 100000, 1000000};
  const std::filesystem::path file = std::filesystem::temp_directory_path() / ("preparation_cost_" + std::to_string(std::rand()) + ".stl");
  std::printf(
      "| body | triangles | read | prepare | expose | Surface | peak so far, MB | hash | drag |\n|---|--:|--:|--:|--:|--:|--:|---|--:|\n");
  for (const int size : sizes)
    for (const auto& [name, body] :
         {std::pair<const char*, TriangleMesh (*)(int)>("ball", ball), {"dented ball", dented_ball}, {"soup", soup}}) {
      const TriangleMesh written = body(size);
      write_stl(file, written);
      std::printf("| %s | %zu |", name, written.triangles.size());
      const TriangleMesh mesh = timed([&] { return read_mesh(file); });
      const Preparation prepared = timed([&] { return prepare(mesh); });
      const Preparation reached = timed([&] { return expose(prepared); });
      const Surface surface = timed([&] { return Surface(reached); });
      rusage usage{};
      getrusage(RUSAGE_SELF, &usage);
      const Vector3d force = wrench(surface, {.wind = Vector3d(8, 4, 2)}, {}, model_for(surface)).total().force;
      std::printf(" %.0f | %016llx | %.15g |\n", static_cast<double>(usage.ru_maxrss) / 1024.0,
                  static_cast<unsigned long long>(hash_of(surface)), force.norm());
    }
  std::filesystem::remove(file);
  return 0;
}
