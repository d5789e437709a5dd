#include <algorithm>
#include <dragcore/body_wind.hpp>
#include <dragcore/gust.hpp>
#include <dragcore/turbulence.hpp>

#include "c/handles.hpp"

using namespace dragcore::c;

namespace {

/// Changes sources or time and prepares the field anew; after an error all is as it was.
template <class Change>
dragcore_status change(dragcore_wind* wind, Change&& how) {
  return guarded([&] {
    require(wind, "wind");
    std::vector<dragcore::WindSource> sources = wind->sources;
    double time = wind->time;
    how(sources, time);
    dragcore_wind changed{sources, time, dragcore::Wind(sources, time)};
    *wind = std::move(changed);
  });
}

/// Adds the field that `make` makes; `placement` may be NULL.
template <class Make>
dragcore_status add(dragcore_wind* wind, const dragcore_placement* placement, Make&& make) {
  return change(wind, [&](std::vector<dragcore::WindSource>& sources, double&) {
    dragcore::WindSource source{.name = "source " + std::to_string(sources.size()), .field = make()};
    if (placement) {
      source.placement = {vector(placement->position), Eigen::Map<const RowMajor3d>(placement->to_world), vector(placement->scale)};
      source.intensity = placement->intensity;
      if (placement->fade_radius != 0.0) source.fade_radius = placement->fade_radius;
    }
    sources.push_back(std::move(source));
  });
}

}  // namespace

extern "C" {

dragcore_status dragcore_wind_create(dragcore_wind** wind) {
  return made(wind, "wind", [] { return new dragcore_wind{{}, 0.0, dragcore::Wind({})}; });
}

void dragcore_wind_destroy(dragcore_wind* wind) { delete wind; }

dragcore_placement dragcore_no_placement(void) { return {{0, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {1, 1, 1}, 1.0, 0.0}; }

dragcore_status dragcore_wind_add_uniform(dragcore_wind* wind, const double velocity[3], const dragcore_placement* placement) {
  return add(wind, placement, [&] {
    require(velocity, "velocity");
    return dragcore::UniformField{vector(velocity)};
  });
}

dragcore_status dragcore_wind_add_vortex(dragcore_wind* wind, double circulation, double core_radius, const dragcore_placement* placement) {
  return add(wind, placement, [&] { return dragcore::VortexField{circulation, core_radius}; });
}

dragcore_status dragcore_wind_add_jet(dragcore_wind* wind, double exit_speed, double diameter, const dragcore_placement* placement) {
  return add(wind, placement, [&] { return dragcore::JetField{exit_speed, diameter}; });
}

dragcore_status dragcore_wind_add_grid(dragcore_wind* wind, const dragcore_grid* grid, const dragcore_placement* placement) {
  return add(wind, placement, [&]() -> dragcore::Field {
    require(grid, "grid");
    require(grid->values, "grid->values");
    const Eigen::Vector3i points(grid->points);
    if ((points.array() < 1).any() || points.cast<double>().prod() > 1e9)
      throw std::invalid_argument("grid: points = " + std::to_string(points[0]) + " x " + std::to_string(points[1]) + " x " +
                                  std::to_string(points[2]) + ", but it must be at least 1 per axis and at most 1e9 in all");
    return std::make_shared<const dragcore::GridField>(
        dragcore::Grid{.points = points,
                       .lower = vector(grid->lower),
                       .upper = vector(grid->upper),
                       .values = Eigen::Map<const Eigen::Matrix3Xd>(grid->values, 3, static_cast<Eigen::Index>(points.prod())),
                       .outside = grid->clamp ? dragcore::Outside::clamp : dragcore::Outside::zero});
  });
}

dragcore_status dragcore_wind_add_turbulence(dragcore_wind* wind, const dragcore_dryden* dryden, const dragcore_placement* placement) {
  return add(wind, placement, [&]() -> dragcore::Field {
    require(dryden, "dryden");
    dragcore::Dryden parameters{.seed = dryden->seed,
                                .intensity = vector(dryden->intensity),
                                .length = vector(dryden->length),
                                .mean_wind = vector(dryden->mean_wind)};
    if (dryden->waves != 0) parameters.waves = dryden->waves;
    return std::make_shared<const dragcore::Turbulence>(parameters);
  });
}

dragcore_status dragcore_wind_set_time(dragcore_wind* wind, double time) {
  return change(wind, [&](std::vector<dragcore::WindSource>&, double& now) { now = time; });
}

dragcore_status dragcore_wind_set_intensity(dragcore_wind* wind, size_t source, double intensity) {
  return change(wind, [&](std::vector<dragcore::WindSource>& sources, double&) {
    if (source >= sources.size())
      throw std::invalid_argument("source = " + std::to_string(source) + ", but the wind has " + std::to_string(sources.size()) +
                                  "; they count from 0 in the order in which they were added");
    sources[source].intensity = intensity;
  });
}

dragcore_status dragcore_wind_sample(const dragcore_wind* wind, const double point[3], double velocity[3], double gradient[9]) {
  return guarded([&] {
    require(wind, "wind");
    require(point, "point");
    const dragcore::WindSample sample = wind->wind.sample(vector(point));
    if (velocity) copy(sample.velocity, velocity);
    if (gradient) Eigen::Map<RowMajor3d>{gradient} = sample.gradient;
  });
}

dragcore_status dragcore_wind_over_body(const dragcore_wind* wind, const dragcore_surface* surface, const double position[3],
                                        const double to_world[9], double tolerance, double* triangle_wind, dragcore_motion* motion) {
  return guarded([&] {
    require(wind, "wind");
    require(surface, "surface");
    require(position, "position");
    require(to_world, "to_world");
    require(motion, "motion");
    const dragcore::BodyPlacement place{vector(position), Eigen::Map<const RowMajor3d>(to_world)};
    dragcore::Motion met = motion_of(*motion);
    auto here = dragcore::BodyWind::within(wind->wind, surface->surface, place, met.reference_point, tolerance);
    if (here.sampling() == dragcore::WindSampling::per_triangle && !triangle_wind)
      here = dragcore::BodyWind(wind->wind, surface->surface, place, met.reference_point, dragcore::WindSampling::affine);
    here.apply_to(met);
    copy(met.wind, motion->wind);
    Eigen::Map<RowMajor3d>{motion->wind_gradient} = met.wind_gradient;
    double* out = triangle_wind;
    for (const Eigen::Vector3d& v : met.triangle_wind) out = std::copy(v.begin(), v.end(), out);
    motion->triangle_wind = met.triangle_wind.empty() ? nullptr : triangle_wind;
  });
}

dragcore_status dragcore_gust_factor(double time, double start, double duration, double* factor) {
  return guarded([&] {
    require(factor, "factor");
    *factor = dragcore::gust_factor({.profile = dragcore::GustProfile::one_minus_cosine, .start = start, .duration = duration, .rest = 0.0},
                                    time);
  });
}

}  // extern "C"
