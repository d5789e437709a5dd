// How much the force on a body depends on how it lies to the directions that its exposure was looked at from: body and wind are turned
// together at random, and nothing should change. Markdown table on stdout, in shares of the mean force.
//   exposure_spread [--turns 50] [--rays 4e6] [FILE...]        without files, bodies of thin parts made here
// The wind blows along the three axes of the body and its diagonal; the table shows the worst of the four, and processor seconds of one
// expose().

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <dragcore/drag.hpp>
#include <dragcore/expose.hpp>
#include <dragcore/mesh_file.hpp>
#include <random>
#include <string>

#include "thin_bodies.hpp"

using namespace dragcore;
using Eigen::Matrix3d;
using Eigen::Vector3d;

int main(int count, char** words) {
  int turns = 50;
  ExposeOptions options;
  std::vector<std::pair<std::string, TriangleMesh>> bodies;
  for (int k = 1; k < count; ++k)
    if (std::strcmp(words[k], "--turns") == 0 && k + 1 < count)
      turns = std::max(2, std::atoi(words[++k]));
    else if (std::strcmp(words[k], "--rays") == 0 && k + 1 < count)
      options.rays = std::atof(words[++k]);
    else
      bodies.emplace_back(words[k], read_mesh(words[k]));
  if (bodies.empty()) bodies = thin_bodies::all();
  std::printf(
      "| body | triangles | range | standard deviation | as given, off the mean | directions | residual | CPU s "
      "|\n|---|--:|--:|--:|--:|--:|--:|--:|\n");
  for (const auto& [name, mesh] : bodies) {
    std::mt19937 engine(1);
    std::normal_distribution<double> normal;
    const std::array<Vector3d, 4> winds{Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ(), Vector3d(1, 1, 1).normalized()};
    std::array<std::vector<double>, 4> forces;
    std::size_t directions = 0;
    double seconds = 0.0, residual = 0.0;
    for (int turn = 0; turn <= turns; ++turn) {
      Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
      if (turn > 0) {
        for (double& x : q.coeffs()) x = normal(engine);
        q.normalize();
      }
      const Matrix3d R = q.toRotationMatrix();
      const Preparation prepared = prepare(transformed(mesh, R, Vector3d::Zero()));
      const std::clock_t began = std::clock();
      const Surface surface(expose(prepared, options));
      seconds += static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC / (turns + 1);
      if (surface.exposure) residual = std::max(residual, surface.exposure->residual);
      directions = std::max(directions, surface.exposure ? surface.exposure->directions.size() : 0);
      for (std::size_t k = 0; k < winds.size(); ++k)
        forces[k].push_back(wrench(surface, {.wind = 10.0 * R * winds[k], .reference_point = surface.centre}, {}, model_for(surface))
                                .total()
                                .force.dot(R * winds[k]));
    }
    double range = 0.0, deviation = 0.0, given = 0.0;
    for (const std::vector<double>& list : forces) {
      double mean = 0.0, square = 0.0;
      for (const double f : list) mean += f / static_cast<double>(list.size());
      for (const double f : list) square += (f - mean) * (f - mean) / static_cast<double>(list.size());
      const auto [least, most] = std::minmax_element(list.begin(), list.end());
      range = std::max(range, (*most - *least) / mean);
      deviation = std::max(deviation, std::sqrt(square) / mean);
      given = std::max(given, std::abs(list[0] / mean - 1.0));
    }
    std::printf("| %s | %zu | %.3f | %.3f | %.3f | %zu | %.3f | %.2f |\n", name.c_str(), mesh.triangles.size(), range, deviation, given,
                directions, residual, seconds);
    std::fflush(stdout);
  }
  return 0;
}
