// Samples of wind at many points: near each other, as a body asks for them, and anywhere in the field.

#include <dragcore/wind.hpp>
#include <random>

#include "rows.hpp"

namespace dragcore::bench {

void add_wind_rows() {
  for (const int points : {32, 128})
    for (const bool coherent : {true, false})
      add_row("wind/" + std::string(coherent ? "coherent" : "random") + "/" + std::to_string(points), [=](benchmark::State& state) {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> uniform(-1.0, 1.0);
        const auto vector = [&](double size) {
          return Eigen::Vector3d(size * uniform(random), size * uniform(random), size * uniform(random));
        };
        Grid grid{.points = Eigen::Vector3i::Constant(points),
                  .lower = Eigen::Vector3d::Constant(-10.0),
                  .upper = Eigen::Vector3d::Constant(10.0)};
        grid.values.resize(3, static_cast<Eigen::Index>(points) * points * points);
        for (Eigen::Index k = 0; k < grid.values.cols(); ++k) grid.values.col(k) = vector(5.0);
        const Wind wind({{.name = "gusts", .field = std::make_shared<const GridField>(std::move(grid))}});
        Eigen::Matrix3Xd where(3, 4096);
        if (coherent) {
          where = body("ball-2048").surface.centroid.matrix().transpose().replicate(1, 2);
        } else {
          for (Eigen::Index k = 0; k < where.cols(); ++k) where.col(k) = vector(9.9);
        }
        Eigen::Matrix3Xd found;
        for (auto _ : state) benchmark::DoNotOptimize((found = wind.velocities(where, Precision::single)).data());
        count(state, static_cast<double>(where.cols()), "per_sample");
        state.SetLabel(Hash().add(found).text());
        double off = 0.0;  // against point by point, in units of a speed that is below the largest
        for (Eigen::Index k = 0; k < where.cols(); k += 61) off = std::max(off, (found.col(k) - wind.velocity(where.col(k))).norm() / 5.0);
        if (!(off <= 2e-6)) wrong(state, "samples differ from those point by point");
      });
}

}  // namespace dragcore::bench
