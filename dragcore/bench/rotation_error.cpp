// How wrong each treatment of spin is: rms error of the torque about the centre, relative to the rms torque, over random motions.
// Markdown table on stdout; seeded, so that it is the same on every run.

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <dragcore/rotation_split.hpp>
#include <dragcore/shapes.hpp>
#include <functional>
#include <limits>
#include <random>
#include <vector>

using namespace dragcore;
using Eigen::Vector3d;

int main() {
  using Method = std::function<Wrench(const Surface&, const Motion&)>;
  const auto quadrature = [](Quadrature order) -> Method {
    return [order](const Surface& s, const Motion& m) { return wrench(s, m, {}, {.quadrature = order}).total(); };
  };
  const auto split = [](RotationSplit choice) -> Method {
    return [choice](const Surface& s, const Motion& m) { return rotation_split_wrench(s, m, {}, choice).total(); };
  };
  const std::vector<std::pair<const char*, Method>> methods = {{"Q1", quadrature(Quadrature::one)},
                                                               {"Q3", quadrature(Quadrature::three)},
                                                               {"Q6", quadrature(Quadrature::six)},
                                                               {"adaptive", quadrature(Quadrature::adaptive)},
                                                               {"split, mended", split({RotationSplit::Formulas::mended, 0.0})},
                                                               {"split, mended, suction", split({RotationSplit::Formulas::mended, 1.0})},
                                                               {"split, as printed", split({RotationSplit::Formulas::printed, 1.0})}};
  struct Body {
    const char* name;
    Shape shape;
    int divisions;
  };
  const std::vector<Body> bodies = {
      {"cube, 12 triangles", Box{1, 1, 1}, 1}, {"plate, 12 triangles", Plate{1, 1, 0.05}, 1}, {"cone of 60°, 48 triangles", Cone{}, 2}};

  std::printf("| body | ωa/V |");
  for (const auto& [name, method] : methods) std::printf(" %s |", name);
  std::printf("\n|---|---|");
  for (std::size_t i = 0; i < methods.size(); ++i) std::printf("---|");
  std::printf("\n");
  for (const Body& body : bodies) {
    const TriangleMesh mesh = triangulate(body.shape, body.divisions);
    const Surface coarse(mesh);
    // Fine integration of the same facets: six points on each of the 4^4 parts of every triangle.
    TriangleMesh refined = mesh;
    for (int level = 0; level < 4; ++level) {
      TriangleMesh next;
      for (const auto& t : refined.triangles) {
        const Vector3d a = refined.vertices[static_cast<std::size_t>(t[0])], b = refined.vertices[static_cast<std::size_t>(t[1])],
                       c = refined.vertices[static_cast<std::size_t>(t[2])];
        const int k = static_cast<int>(next.vertices.size());
        next.vertices.insert(next.vertices.end(), {a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)});
        for (const Eigen::Vector3i& part :
             {Eigen::Vector3i(0, 3, 5), Eigen::Vector3i(3, 1, 4), Eigen::Vector3i(5, 4, 2), Eigen::Vector3i(3, 4, 5)})
          next.triangles.push_back(part + Eigen::Vector3i::Constant(k));
      }
      refined = welded(next);
    }
    const Surface fine(refined);
    for (const double ratio : {0.0, 0.1, 0.3, 1.0, 3.0, std::numeric_limits<double>::infinity()}) {
      std::mt19937 engine(1);
      std::normal_distribution<double> normal;
      const auto direction = [&] { return Vector3d(normal(engine), normal(engine), normal(engine)).normalized(); };
      double size = 0.0;
      std::vector<double> error(methods.size(), 0.0);
      for (int i = 0; i < 30; ++i) {
        Motion motion{.velocity = direction(), .angular_velocity = direction()};
        if (std::isinf(ratio))
          motion.velocity.setZero();
        else
          motion.angular_velocity *= ratio;
        // Rotation-induced torque: that of the same motion without spin is taken off, so that 100 % is "no rotation at all".
        Motion still = motion;
        still.angular_velocity.setZero();
        const Vector3d base = wrench(fine, still, {}, {}).total().torque;
        const Vector3d exact = wrench(fine, motion, {}, {.quadrature = Quadrature::six}).total().torque - base;
        size += exact.squaredNorm();
        for (std::size_t k = 0; k < methods.size(); ++k)
          error[k] += (methods[k].second(coarse, motion).torque - base - exact).squaredNorm();
      }
      std::printf("| %s | %s |", body.name, std::isinf(ratio) ? "∞" : std::to_string(ratio).substr(0, 3).c_str());
      for (const double e : error) {
        if (size > 0.0)
          std::printf(" %.1f %% |", 100.0 * std::sqrt(e / size));
        else
          std::printf(" %s |", e < 1e-20 ? "exact" : "wrong");
      }
      std::printf("\n");
    }
  }

  // The note's own example: a cube of 12 triangles that spins about its vertical axis in still air.
  const Surface cube(triangulate(Box{}, 1)), fine_cube(triangulate(Box{}, 64));
  const Motion spinning{.angular_velocity = Vector3d::UnitZ()};
  const auto torque = [&](const Wrench& w) { return w.torque.z(); };
  std::printf("\nM_z / (rho omega^2 a^5): fine integration %.5f",
              torque(wrench(fine_cube, spinning, {.density = 1.0}, {.quadrature = Quadrature::six}).total()));
  for (const auto& [name, method] : methods) std::printf("; %s %.5f", name, torque(method(cube, spinning)) / Medium{}.density);
  std::printf("\n");

  // What they cost, in one run: medians of 51 rounds of 400 evaluations of the cube.
  std::printf("\n| |");
  for (const auto& [name, method] : methods) std::printf(" %s |", name);
  std::printf("\n|---|");
  for (std::size_t i = 0; i < methods.size(); ++i) std::printf("---|");
  for (const double ratio : {0.001, 0.3, 3.0}) {
    const Motion motion{.velocity = {0.6, 0.5, 0.6}, .angular_velocity = ratio * Vector3d(0.3, 0.5, 0.8)};
    std::vector<std::vector<double>> seconds(methods.size());
    double sink = 0.0;
    for (int round = 0; round < 51; ++round)
      for (std::size_t k = 0; k < methods.size(); ++k) {
        const auto start = std::chrono::steady_clock::now();
        for (int i = 0; i < 400; ++i) sink += methods[k].second(cube, motion).torque.x();
        seconds[k].push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
      }
    std::printf("\n| time over that of Q1, ωa/V = %g |", ratio);
    for (auto& rounds : seconds) std::nth_element(rounds.begin(), rounds.begin() + 25, rounds.end());
    for (const auto& rounds : seconds) std::printf(" %.1f |", rounds[25] / seconds[0][25]);
    if (!std::isfinite(sink)) return 1;
  }
  std::printf("\n");
}
