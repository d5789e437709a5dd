#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <dragcore/bake.hpp>
#include <limits>
#include <stdexcept>
#include <string>

#include "support/direction_sample.hpp"
#include "support/require.hpp"

namespace dragcore {

using Eigen::Vector3d;

namespace {

using Row = Eigen::Array<float, 8, 1>;

// Square of a speed [m^2/s^2] below which nothing moves: what it does is no normal number.
constexpr double still = 1e-280;

/// Sum over the rows of each node times their factors, interpolated.
template <std::size_t Rows>
Row weighted(const DirectionMap& map, const Vector3d& direction, const std::array<float, Rows>& factor) {
  const DirectionMap::Sample at = direction_sample(map, direction);
  Row sum = Row::Zero();
  for (int corner = 0; corner < 3; ++corner) {
    const float* rows = map.row(at.node[corner], 0);
    Row node = factor[0] * Eigen::Map<const Row>(rows);
    for (std::size_t row = 1; row < Rows; ++row) node += factor[row] * Eigen::Map<const Row>(rows + 8 * row);
    sum += at.weight[corner] * node;
  }
  return sum;
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
    require(
        strain <= 1e-9 * G.norm(), "baked wrench: rate of strain of motion.wind_gradient", strain,
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
    sum = weighted<1>(body.steady, u, {1.0f});
  } else if (flows || turns) {
    const double flow = std::sqrt(flow2), fast = std::sqrt(turned2), size = std::sqrt(size2);
    const Eigen::Vector3f by_flow = (turned2 / size2 / (size + flow) * u).cast<float>(),
                          by_spin = (flow2 / size2 / (size + fast) * turned).cast<float>();
    sum = weighted<4>(body.tumble, turned, {static_cast<float>(turned2 / size2), by_flow.x(), by_flow.y(), by_flow.z()});
    if (flows)
      sum += weighted<1>(body.steady, u, {static_cast<float>(flow2 / size2)}) +
             weighted<3>(body.rate, u, {by_spin.x(), by_spin.y(), by_spin.z()});
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

/// Many motions, block by block: each step is a loop of its own that the compiler turns into vectors.
class Block {
 public:
  static constexpr int size = 16;

  /// False where something is not as simple as a uniform wind at usual speeds, or power is nearly nothing: entries are then to be evaluated
  /// one by one.
  bool evaluate(const BakedBody& body, const Motion* motions, double density, Wrench* results) {
    // 0 and -0 are the only numbers without bits but the sign's.
    std::uint64_t spin = 0, gradient = 0, winds = 0;
    for (int k = 0; k < size; ++k) {
      for (int c = 0; c < 3; ++c) spin |= std::bit_cast<std::uint64_t>(motions[k].angular_velocity[c]);
      for (int c = 0; c < 9; ++c) gradient |= std::bit_cast<std::uint64_t>(motions[k].wind_gradient.data()[c]);
      winds |= motions[k].triangle_wind.size();
    }
    if (gradient << 1 != 0 || winds != 0) return false;
    return spin << 1 == 0 ? evaluate<false>(body, motions, density, results) : evaluate<true>(body, motions, density, results);
  }

 private:
  using Lanes = float[size];
  struct Samples {
    int node[3][size];
    Lanes weight[3];
  };

  template <bool Spins>
  bool evaluate(const BakedBody& body, const Motion* motions, double density, Wrench* results) {
    // A map without spin does not feel it, but for the velocity of its centre.
    if (Spins && body.tumble.frequency == 0) return false;
    if (!read<Spins>(body, motions)) return false;
    locate(body.steady, flow_, steady_);
    if constexpr (Spins) {
      locate(body.rate, flow_, rate_);
      locate(body.tumble, axis_, tumble_);
      weigh();
    }
    return sum<Spins>(body, motions, density, results);
  }

  template <bool Spins>
  bool read(const BakedBody& body, const Motion* motions) {
    // Squares of these speeds are numbers in single precision, too.
    const auto usual = [](double speed2) { return speed2 > 1e-24 && speed2 < 1e24; };
    bool good = true;
    for (int k = 0; k < size; ++k) {
      const Motion& m = motions[k];
      Vector3d u = m.wind - m.velocity;
      if constexpr (Spins) {
        u -= m.angular_velocity.cross(body.centre - m.reference_point);
        const Vector3d turned = body.length * m.angular_velocity;
        const double turned2 = turned.squaredNorm();
        good &= turned2 == 0.0 || usual(turned2);
        turned2_[k] = static_cast<float>(turned2);
        for (int c = 0; c < 3; ++c) axis_[c][k] = turned_[c][k] = static_cast<float>(turned[c]);
        if (turned2 == 0.0) axis_[0][k] = 1.0f;  // any, for it has no weight
        size2_[k] = turned2;
      }
      const double flow2 = u.squaredNorm();
      good &= usual(flow2);
      flow2_[k] = static_cast<float>(flow2);
      size2_[k] = Spins ? size2_[k] + flow2 : flow2;
      flow_[0][k] = static_cast<float>(u[0]), flow_[1][k] = static_cast<float>(u[1]), flow_[2][k] = static_cast<float>(u[2]);
    }
    return good;
  }

  /// As direction_sample().
  static void locate(const DirectionMap& map, const Lanes* direction, Samples& at) {
    const int side = map.side(), last = map.frequency - 1, centre = map.frequency * (side + 1);
    const float frequency = static_cast<float>(map.frequency);
    for (int k = 0; k < size; ++k) {
      const float x = direction[0][k], y = direction[1][k], z = direction[2][k];
      const float scale = frequency / (std::abs(x) + std::abs(y) + std::abs(z));
      const float fold = 0.5f * (std::abs(z) - z), across = scale * (std::abs(x) + fold), up = scale * (std::abs(y) + fold);
      const int i = std::min(static_cast<int>(across), last), j = std::min(static_cast<int>(up), last);
      const int left = std::bit_cast<std::int32_t>(x) >> 31, below = std::bit_cast<std::int32_t>(y) >> 31;  // -1 or 0
      const float a = across - static_cast<float>(i), b = up - static_cast<float>(j), rest = 1.0f - a - b;
      const int column = left | 1, row = (side ^ below) - below, corner = centre + ((i ^ left) - left) + ((j ^ below) - below) * side;
      const int beyond = std::bit_cast<std::int32_t>(rest) >> 31;
      const float negative = std::bit_cast<float>(std::bit_cast<std::int32_t>(rest) & beyond);
      at.node[0][k] = corner + (beyond & (column + row)), at.node[1][k] = corner + column, at.node[2][k] = corner + row;
      at.weight[0][k] = std::abs(rest), at.weight[1][k] = a + negative, at.weight[2][k] = b + negative;
    }
  }

  /// The four factors of the maps, in units of U^2 + w^2.
  void weigh() {
    for (int k = 0; k < size; ++k) {
      const float size2 = flow2_[k] + turned2_[k], root = std::sqrt(size2);
      const float of_flow = flow2_[k] / size2, of_spin = turned2_[k] / size2;
      const float by_spin = of_flow / (root + std::sqrt(turned2_[k])), by_flow = of_spin / (root + std::sqrt(flow2_[k]));
      factor_[0][k] = of_flow, factor_[4][k] = of_spin;
      for (int c = 0; c < 3; ++c) factor_[1 + c][k] = by_spin * turned_[c][k], factor_[5 + c][k] = by_flow * flow_[c][k];
    }
  }

  template <std::size_t Rows>
  Row weighted_rows(const DirectionMap& map, const Samples& at, int first, int k) const {
    const auto node = [&](int n) -> Row {
      const float* rows = map.row(at.node[n][k], 0);
      Row loads = factor_[first][k] * Eigen::Map<const Row>(rows);
      for (std::size_t row = 1; row < Rows; ++row) loads += factor_[first + row][k] * Eigen::Map<const Row>(rows + 8 * row);
      return at.weight[n][k] * loads;
    };
    return node(0) + node(1) + node(2);
  }

  template <bool Spins>
  bool sum(const BakedBody& body, const Motion* motions, double density, Wrench* results) const {
    const double unit = 0.5 * density * body.area;
    const float least = static_cast<float>(1e-3 * body.rms_force);
    for (int k = 0; k < size; ++k) {
      Row loads;
      if constexpr (Spins) {
        loads = weighted_rows<1>(body.steady, steady_, 0, k) + weighted_rows<3>(body.rate, rate_, 1, k) +
                weighted_rows<4>(body.tumble, tumble_, 4, k);
      } else {
        const auto row = [&](int n) -> Row { return steady_.weight[n][k] * Eigen::Map<const Row>(body.steady.row(steady_.node[n][k], 0)); };
        loads = row(0) + row(1) + row(2);
      }
      float taken = 0.0f, speeds = 0.0f;
      for (int c = 0; c < 3; ++c) {
        taken += loads[c] * flow_[c][k], speeds += std::abs(flow_[c][k]);
        if constexpr (Spins) taken -= loads[4 + c] * turned_[c][k], speeds += std::abs(turned_[c][k]);
      }
      // Clearly braked, whatever rounds: an error of 1e-6 of the rms force at most. The others are looked at one by one.
      if (!(taken > least * speeds)) [[unlikely]]
        return false;
      const Eigen::Array<double, 8, 1> load = unit * size2_[k] * loads.cast<double>();
      const Vector3d arm = body.centre - motions[k].reference_point, force = load.head<3>();
      results[k].force = force;
      results[k].torque = body.length * load.segment<3>(4).matrix() + arm.cross(force);
    }
    return true;
  }

  Lanes flow_[3], turned_[3], axis_[3], flow2_, turned2_, factor_[8];
  double size2_[size];
  Samples steady_, rate_, tumble_;
};

void check(const BakedBody& body, const Medium& medium) {
  require(body.steady.frequency > 0, "baked wrench: frequency of its map", body.steady.frequency,
          "it must be above 0: make the body by bake(), or read it from a file");
  require(medium.viscosity == 0.0, "baked wrench: viscosity", medium.viscosity,
          "it must be 0: a map is of one shape of the force at all speeds, and with viscosity that shape changes with the Reynolds number. "
          "Take wrench() of the surface where Re is below 1e4");
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
  throw std::invalid_argument(
      "baked wrench" + entry +
      ": the result is not finite; wind, velocity, spin and reference point must be finite, and speeds below 1e100 m/s");
}

}  // namespace

Wrench wrench(const BakedBody& body, const Motion& motion, const Medium& medium) {
  check(body, medium);
  const Wrench result = unchecked(body, motion, medium);
  if (!finite(result)) not_finite("");
  return result;
}

void wrenches(const BakedBody& body, std::span<const Motion> motions, const Medium& medium, std::span<Wrench> results) {
  require(results.size() == motions.size(), "wrenches: entries of results", results.size(),
          [&] { return "there are " + std::to_string(motions.size()) + " motions"; });
  check(body, medium);
  constexpr std::size_t block = Block::size;
  Block vectors;
  for (std::size_t first = 0; first < motions.size(); first += block) {
    if (first + block <= motions.size() && vectors.evaluate(body, &motions[first], medium.density, &results[first])) continue;
    for (std::size_t k = first; k < std::min(first + block, motions.size()); ++k) results[k] = unchecked(body, motions[k], medium);
  }
  double sum = 0.0;  // not finite where one entry is not
  for (const Wrench& one : results) sum += 0.0 * (one.force.sum() + one.torque.sum());
  if (sum == 0.0) return;
  for (std::size_t k = 0; k < results.size(); ++k)
    if (!finite(results[k])) not_finite(", entry " + std::to_string(k));
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
