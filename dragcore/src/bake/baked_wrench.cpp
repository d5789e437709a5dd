#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <dragcore/bake.hpp>
#include <limits>
#include <stdexcept>
#include <string>

#include "support/require.hpp"

namespace dragcore {

using Eigen::Vector3d;

namespace {

using Row = Eigen::Array<float, 8, 1>;

// Square of a speed [m^2/s^2] below which nothing moves: what it does is no normal number.
constexpr double still = 1e-280;

/// 1, or -1 of what has a minus.
int sign(double x) { return 1 - 2 * static_cast<int>(std::bit_cast<std::uint64_t>(x) >> 63); }

/// @param direction  any length; the sum of the absolute components must be a normal number
[[gnu::always_inline]] inline DirectionMap::Sample sample(const DirectionMap& map, const Vector3d& direction) {
  // Without branches: directions are often random, and a branch guessed wrong costs more than all of this.
  const double scale = map.frequency / (std::abs(direction.x()) + std::abs(direction.y()) + std::abs(direction.z()));
  // The lower half is folded out over the diagonals of the square, on which z = 0: (x, y) -> (1 - y, 1 - x).
  const double fold = 0.5 * (std::abs(direction.z()) - direction.z());
  const double across = scale * (std::abs(direction.x()) + fold), up = scale * (std::abs(direction.y()) + fold);
  const int i = std::min(static_cast<int>(across), map.frequency - 1), j = std::min(static_cast<int>(up), map.frequency - 1);
  const float a = static_cast<float>(across - i), b = static_cast<float>(up - j);
  // Cells are cut along the same diagonals, so that no triangle lies on both sides of z = 0. Its third corner is the one to which `rest`
  // belongs: the cell's inner one, or, where `rest` is negative, the outer one.
  const float rest = 1.0f - a - b, beyond = std::min(rest, 0.0f);
  const int column = sign(direction.x()), row = map.side() * sign(direction.y());
  const int corner = map.frequency * (map.side() + 1) + i * column + j * row;
  return {{corner + (rest < 0.0f) * (column + row), corner + column, corner + row}, {std::abs(rest), a + beyond, b + beyond}};
}

/// Sum over the rows of each node, times their factors, times the node's weight.
template <std::size_t Rows>
void add(Row& sum, const DirectionMap& map, const DirectionMap::Sample& sample, const std::array<float, Rows>& factor) {
  for (int corner = 0; corner < 3; ++corner)
    for (int row = 0; row < static_cast<int>(Rows); ++row)
      sum += sample.weight[corner] * factor[row] * Eigen::Map<const Row>(map.row(sample.node[corner], row));
}

/// What moves, seen from the centre of the map.
struct RelativeMotion {
  Vector3d u, spin;  ///< of the air relative to the body [m/s], of the body relative to the air [rad/s]
  Vector3d arm;      ///< from the reference point to the centre of the map [m]
};

RelativeMotion relative_motion(const BakedBody& body, const Motion& motion) {
  if (!motion.triangle_wind.empty()) [[unlikely]]
    require(false, "baked wrench: entries of motion.triangle_wind", motion.triangle_wind.size(),
          "a map knows no triangles: give wind at the reference point, or call wrench() of the surface");
  RelativeMotion relative{motion.wind - motion.velocity, motion.angular_velocity, body.centre - motion.reference_point};
  const Eigen::Matrix3d& G = motion.wind_gradient;
  if (G.cwiseAbs().sum() != 0.0) {
    const double strain = 0.5 * (G + G.transpose()).norm();
    // 1e-9: the rounding of a gradient that was turned into the body frame.
    require(strain <= 1e-9 * G.norm(), "baked wrench: rate of strain of motion.wind_gradient", strain,
            "only its turning part is baked, so it must be 0 [1/s]: leave the symmetric part out where it matters little, or call wrench() of "
            "the surface");
    require(body.tumble.frequency > 0, "baked wrench: motion.wind_gradient of norm", G.norm(),
            "this map was baked without Effect::spin, and knows uniform winds only");
    relative.spin -= 0.5 * Vector3d(G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1));
    relative.u += G * relative.arm;
  }
  relative.u -= motion.angular_velocity.cross(relative.arm);
  if (body.tumble.frequency == 0) relative.spin.setZero();
  return relative;
}

/// Force and torque over L at the centre of the map, per density/2 A, speeds as they are.
/// @param turned  spin times L
struct Loads {
  Vector3d force, torque;
};
Loads loads(const BakedBody& body, const Vector3d& u, const Vector3d& turned) {
  const double flow2 = u.squaredNorm(), turned2 = turned.squaredNorm();
  const bool flows = flow2 > still, turns = turned2 > still;
  // In units of both squares, coefficients are of order 1 whatever the speed, and floats serve.
  const double size2 = flow2 + turned2;
  // 1e100 is what wrench() takes of a speed. Whatever is larger, or no number, has no place on a map.
  if (!(size2 <= 1e200)) [[unlikely]]
    return {Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()), Vector3d::Zero()};
  Row sum = Row::Zero();
  if (flows && !turns) [[likely]] {
    const DirectionMap::Sample at = sample(body.steady, u);
    for (int corner = 0; corner < 3; ++corner) sum += at.weight[corner] * Eigen::Map<const Row>(body.steady.row(at.node[corner], 0));
  } else if (flows || turns) {
    const double flow = std::sqrt(flow2), fast = std::sqrt(turned2), size = std::sqrt(size2);
    const Eigen::Vector3f by_flow = (turned2 / size2 / (size + flow) * u).cast<float>(),
                          by_spin = (flow2 / size2 / (size + fast) * turned).cast<float>();
    if (flows) {
      add<1>(sum, body.steady, sample(body.steady, u), {static_cast<float>(flow2 / size2)});
      add<3>(sum, body.rate, sample(body.rate, u), {by_spin.x(), by_spin.y(), by_spin.z()});
    }
    add<4>(sum, body.tumble, sample(body.tumble, turned),
           {static_cast<float>(turned2 / size2), by_flow.x(), by_flow.y(), by_flow.z()});
  }
  Loads found{sum.head<3>().matrix().cast<double>(), sum.segment<3>(4).matrix().cast<double>()};
  // The air takes energy: (force, torque) . (u, -spin) >= 0. Left is a billionth of what it might be, more than rounding can turn.
  const double taken = found.force.dot(u) - found.torque.dot(turned);
  const double most2 = size2 * (found.force.squaredNorm() + found.torque.squaredNorm());
  if (taken * std::abs(taken) < 1e-18 * most2) {
    const double share = (1e-9 * std::sqrt(most2) - taken) / size2;
    found.force += share * u, found.torque -= share * turned;
  }
  return {size2 * found.force, size2 * found.torque};
}

void check_density(const Medium& medium) {
  require(medium.density >= 0.0 && std::isfinite(medium.density), "baked wrench: density", medium.density,
          "it must be finite and not negative [kg/m^3]");
}

Wrench unchecked(const BakedBody& body, const Motion& motion, const Medium& medium) {
  const RelativeMotion relative = relative_motion(body, motion);
  const Loads found = loads(body, relative.u, body.length * relative.spin);
  const double scale = 0.5 * medium.density * body.area;
  const Vector3d force = scale * found.force;
  return {force, scale * body.length * found.torque + relative.arm.cross(force)};
}

bool finite(const Wrench& w) { return std::isfinite(w.force.sum() + w.torque.sum()); }

[[noreturn]] void not_finite(const std::string& entry) {
  throw std::invalid_argument("baked wrench" + entry +
                              ": the result is not finite; wind, velocity, spin and reference point must be finite, and speeds below 1e100 m/s");
}

}  // namespace

Wrench wrench(const BakedBody& body, const Motion& motion, const Medium& medium) {
  check_density(medium);
  const Wrench result = unchecked(body, motion, medium);
  if (!finite(result)) not_finite("");
  return result;
}

void wrenches(const BakedBody& body, std::span<const Motion> motions, const Medium& medium, std::span<Wrench> results) {
  require(results.size() == motions.size(), "wrenches: entries of results", results.size(),
          [&] { return "there are " + std::to_string(motions.size()) + " motions"; });
  check_density(medium);
  for (std::size_t k = 0; k < motions.size(); ++k) {
    results[k] = unchecked(body, motions[k], medium);
    if (!finite(results[k])) not_finite(", entry " + std::to_string(k));
  }
}

Matrix6d resistance(const BakedBody& body, const Motion& motion, const Medium& medium) {
  require(motion.wind_gradient.isZero(0.0), "baked resistance: motion.wind_gradient of norm", motion.wind_gradient.norm(),
          "S (V_air - V) is the wrench in a uniform wind only: leave the gradient out, and add what it changes to the external wrench");
  const Wrench drag = wrench(body, motion, medium);
  // Angular components in units of length, so that one number can stand for the drag across the motion.
  Vector6d velocity, w;
  velocity << motion.wind - motion.velocity, -body.length * motion.angular_velocity;
  w << drag.force, drag.torque / body.length;
  if (body.tumble.frequency == 0) velocity.tail<3>().setZero();  // not felt
  Matrix6d s = Matrix6d::Zero();
  const double power = w.dot(velocity), size = velocity.norm();
  if (!(power > 0.0)) return s;
  const Vector6d along = velocity / size;
  s.selfadjointView<Eigen::Lower>().rankUpdate(Vector6d(w / std::sqrt(power)));
  s += power / (size * size) * (Matrix6d::Identity() - along * along.transpose());
  s.bottomRows<3>() *= body.length, s.rightCols<3>() *= body.length;
  return s.selfadjointView<Eigen::Lower>();
}

}  // namespace dragcore
