#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dragcore/correction.hpp>

#include "drag/corrected_flow.hpp"
#include "drag/energy_balance.hpp"
#include "drag/relative_flow.hpp"
#include "support/direction_sample.hpp"
#include "support/require.hpp"
#include "support/triangle_second_moment.hpp"

namespace dragcore {

using Eigen::Vector3d;

namespace {

void check_map(const DirectionMap& map) {
  require(map.frequency > 0 && map.frequency <= 1024, "correction: frequency of its map", map.frequency, "it must be from 1 to 1024");
  require(map.columns == 1, "correction: rows at each node of its map", map.columns, "one is needed");
  require(map.values.size() == 8u * static_cast<std::size_t>(map.nodes()), "correction: numbers of its map", map.values.size(),
          [&] { return std::to_string(8 * map.nodes()) + " are needed"; });
}

}  // namespace

void validate(const Correction& correction) {
  const DirectionMap& map = correction.map;
  check_map(map);
  require(std::all_of(map.values.begin(), map.values.end(), [](float x) { return std::isfinite(x); }), "correction: a number of its map",
          "not finite", "all must be");
  require(correction.least_reynolds >= 0.0 && correction.least_reynolds <= correction.most_reynolds, "correction: least Reynolds number",
          correction.least_reynolds, "it must be from 0 to the largest");
}

void check_correction(const Correction& correction, const Surface& surface, const Medium& medium) {
  check_map(correction.map);
  require(!correction.viscous || medium.viscosity > 0.0, "correction: viscosity of the medium", medium.viscosity,
          "this body was calibrated at a low Reynolds number, where its law needs the viscosity: set Medium::viscosity");
  if (!correction.body) return;
  double apart = 0.0;
  for (std::size_t k = 0; k < correction.body->size(); ++k)
    apart = std::max(apart, std::abs((*correction.body)[k] - surface.shape_moments[k]));
  require(apart <= same_body, "correction: difference of shape moments between this surface and the calibrated one", apart, [&] {
    return "at most " + std::to_string(same_body) +
           " is the same body: take the mesh that was calibrated, in the same axes, prepared in the same way, or calibrate this one";
  });
}

CorrectedFlow::CorrectedFlow(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model)
    : arm_(surface.centre - motion.reference_point) {
  const RelativeFlow flow(surface, motion, ActiveEffects(motion, model));
  u_.setZero();
  for (std::size_t p = 0; p < surface.parts.size(); ++p)
    u_ += surface.parts[p].area / surface.total_area * flow.at_place(p, surface.centre);
  turning_ = flow.turning();
  const double travel = u_.squaredNorm(), turned = flow.variation_per_metre() * surface.radius;
  if (!(travel > 0.0) || !(travel < 1e200)) return;  // as wrench() has it of speeds
  const double directed = travel / (travel + turned * turned);
  const DirectionMap& map = model.correction->map;
  const DirectionMap::Sample at = direction_sample(map, u_ / std::sqrt(travel));
  Eigen::Array<double, 8, 1> found = Eigen::Array<double, 8, 1>::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    found += double{at.weight[k]} * Eigen::Map<const Eigen::Array<float, 8, 1>>(map.row(at.node[k], 0)).cast<double>();
  const double scale = 0.5 * medium.density * travel * surface.total_area * directed;
  force_ = scale * found.head<3>().matrix();
  torque_ = scale * surface.radius * found.segment<3>(4).matrix();
}

double CorrectedFlow::share(const Wrench& of_law) const {
  const Vector3d about_centre = of_law.torque - arm_.cross(of_law.force);
  EnergyBalance balance;
  balance.add(std::max(0.0, of_law.force.dot(u_) - about_centre.dot(turning_)), std::max(0.0, torque_.dot(turning_) - force_.dot(u_)));
  return balance.gain_share();
}

Wrench CorrectedFlow::wrench(double share) const { return {share * force_, share * (torque_ + arm_.cross(force_))}; }

void add_spread_correction(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model,
                           Eigen::Matrix<double, 6, Eigen::Dynamic>& by_triangle) {
  const Wrench of_law{by_triangle.topRows<3>().rowwise().sum(), by_triangle.bottomRows<3>().rowwise().sum()};
  const Wrench whole = CorrectedFlow(surface, motion, medium, model).beside(of_law);
  const Vector3d arm = surface.centre - motion.reference_point;
  const auto from_centre = [&](Eigen::Index i) { return Vector3d(surface.centroid.row(i).matrix().transpose() - surface.centre); };
  const auto moment_of = [&](Eigen::Index i) {  // of a triangle about its own centroid, per area
    const Eigen::Matrix3d second =
        triangle_second_moment(Vector3d(surface.edge_ab.row(i).matrix()), Vector3d(surface.edge_ac.row(i).matrix()));
    return Eigen::Matrix3d(second.trace() * Eigen::Matrix3d::Identity() - second);
  };
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Vector3d r = from_centre(i);
    inertia += surface.area[i] * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose() + moment_of(i));
  }
  const Vector3d turn = inertia.ldlt().solve(Vector3d(whole.torque - arm.cross(whole.force)));
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Vector3d r = from_centre(i), force = surface.area[i] * (whole.force / surface.total_area + turn.cross(r));
    by_triangle.col(i).head<3>() += force;
    by_triangle.col(i).tail<3>() += (arm + r).cross(force) + surface.area[i] * (moment_of(i) * turn);
  }
}

}  // namespace dragcore
