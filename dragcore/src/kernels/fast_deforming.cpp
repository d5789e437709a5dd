#include "drag/fast_deforming.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <vector>

#include "kernels/deforming_kernel.hpp"
#include "kernels/part_flow.hpp"
#include "support/for_each_index.hpp"

namespace dragcore {

namespace {

using kernels::DeformingTask, kernels::vertex_row, kernels::force_row, kernels::lanes;

class KernelDeforming final : public FastDeforming {
 public:
  KernelDeforming(std::span<const Eigen::Vector3i> given, std::size_t vertices) : first_(vertices + 1) {
    std::vector<Eigen::Vector3i> triangles;
    for (const Eigen::Vector3i& t : given)
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    // Triangles side by side find the rows of their corners in the cache, as far as the order of the vertices has any.
    std::stable_sort(triangles.begin(), triangles.end(),
                     [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) { return a.minCoeff() < b.minCoeff(); });
    for (const Eigen::Vector3i& t : triangles)
      for (const int corner : t) ++first_[static_cast<std::size_t>(corner) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    incident_.resize(3 * triangles.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (const int corner : triangles[t])
        incident_[next[static_cast<std::size_t>(corner)]++] = static_cast<std::uint32_t>(force_row * kernels::force_place(t));
    // What fills up the last group repeats the last triangle, and no vertex takes its force.
    corners_.resize((triangles.size() + lanes - 1) / lanes);
    for (std::size_t slot = 0; slot < lanes * corners_.size(); ++slot)
      for (int k = 0; k < 3; ++k)
        corners_[slot / lanes].of[k][slot % lanes] =
            static_cast<std::uint32_t>(vertex_row) * static_cast<std::uint32_t>(triangles[std::min(slot, triangles.size() - 1)][k]);
    vertex_rows_ = kernels::Aligned<float>(vertex_row * vertices);
    force_rows_ = kernels::Aligned<float>(force_row * lanes * corners_.size());
  }

  bool forces(VertexArray<const float> position, VertexArray<const float> velocity, VertexArray<const float> wind, const DeformingLaw& law,
              VertexArray<float> force) override {
    if (!fits(law)) return false;
    // Of a law that needs no body.
    const ActiveEffects active({}, {}, law.local.law(), {});
    // A wind that all have is copied, for rows are read four numbers at a time.
    const float everywhere[4] = {wind.count > 0 ? wind.first[0] : 0.0f, wind.count > 0 ? wind.first[1] : 0.0f,
                                 wind.count > 0 ? wind.first[2] : 0.0f, 0.0f};
    const DeformingTask task{.vertices = position.count,
                             .corners = corners_.data(),
                             .first = first_.data(),
                             .incident = incident_.data(),
                             .vertex_rows = vertex_rows_.data(),
                             .force_rows = force_rows_.data(),
                             .position = {position.first, position.stride},
                             .velocity = {velocity.first, velocity.stride},
                             .wind = {wind.stride == 0 ? everywhere : wind.first, wind.stride},
                             .force = force.first,
                             .force_stride = force.stride,
                             .law = kernels::resolved(law.local, active, {}, 0.0),
                             .two_sided = law.two_sided,
                             .scale = static_cast<float>(law.density / 108.0)};
    // Some six microseconds each: several times what it takes to hand them over.
    const auto in_chunks = [](std::size_t count, std::size_t chunk, const auto& work) {
      for_each_index((count + chunk - 1) / chunk, 1, [&](std::size_t k) { work(k * chunk, std::min((k + 1) * chunk, count)); });
    };
    in_chunks(task.vertices, 2048, [&](std::size_t first, std::size_t last) { kernels::fill_vertex_rows(task, first, last); });
    Exact exact{task, law, force_rows_.data()};
    in_chunks(corners_.size(), 128,
              [&](std::size_t first, std::size_t last) { kernels::fill_force_rows(task, first, last, &Exact::one_by_one, &exact); });
    if (exact.failed) return false;
    in_chunks(task.vertices, 2048, [&](std::size_t first, std::size_t last) { kernels::sum_forces(task, first, last); });
    return true;
  }

 private:
  /// A triangle in double precision, of the same rows.
  struct Exact {
    const DeformingTask& task;
    const DeformingLaw& law;
    float* rows;
    std::atomic<bool> failed{false};

    static void one_by_one(void* context, std::size_t triangle) {
      Exact& self = *static_cast<Exact*>(context);
      Eigen::Vector3d place[3], u = Eigen::Vector3d::Zero();
      for (int k = 0; k < 3; ++k) {
        const float* const row = self.task.vertex_rows + self.task.corners[triangle / lanes].of[k][triangle % lanes];
        place[k] = Eigen::Map<const Eigen::Vector3f>(row).cast<double>();
        u += Eigen::Map<const Eigen::Vector3f>(row + vertex_row / 2).cast<double>();
      }
      const Eigen::Vector3d force = self.law.corner_force(place[1] - place[0], place[2] - place[0], u / 3.0);
      if (!(force.array().abs() <= largest_deforming_force).all()) self.failed.store(true, std::memory_order_relaxed);
      Eigen::Map<Eigen::Vector3f>(self.rows + force_row * kernels::force_place(triangle)) = force.cast<float>();
    }
  };

  /// Whether the law times the density leaves room in single precision for what the kernel lets through: products of up to 1e27.
  static bool fits(const DeformingLaw& given) {
    const Law& law = given.local.law();
    double sum = law.friction + 4.0 * law.base_suction * (1.0 + law.base_edge);
    for (const Law::Polynomial* p : {&law.windward, &law.leeward})
      for (const double coefficient : *p) sum += std::abs(coefficient);
    return sum < 1e6 && given.density < 1e6 && sum * given.density < 1e6 && (law.base_suction == 0.0 || law.base_edge > 1e-10);
  }

  std::vector<std::uint32_t> first_, incident_;
  std::vector<kernels::CornerRows> corners_;
  kernels::Aligned<float> vertex_rows_, force_rows_;
};

}  // namespace

std::unique_ptr<FastDeforming> fast_deforming(std::span<const Eigen::Vector3i> triangles, std::size_t vertices) {
  return std::make_unique<KernelDeforming>(triangles, vertices);
}

}  // namespace dragcore
