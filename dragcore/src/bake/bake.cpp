#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <dragcore/bake.hpp>
#include <functional>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "support/require.hpp"

namespace dragcore {

using Eigen::Vector3d;

namespace {

constexpr std::array frequencies = {2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96, 112, 128};
constexpr int steady_samples = 2000, spin_samples = 300;
// Slopes are secants over this share of the larger speed to either side. Wider than a tangent: they serve beside it, too, and faces
// edge-on, where slopes jump, give the mean of both. Balls want the second wide, plates narrow: at a spin ratio of 1 the error of a ball
// falls from 21 to 7 % between 0.1 and 0.2, and that of a plate grows from 8.5 to 8.9 %.
constexpr double spin_step = 0.1, flow_step = 0.2;
// Of the maps for spin. With 4 their errors at spin ratios of 0.3 and 1 are up to a tenth smaller, and the maps by two thirds larger; more
// changes nothing, for most of the error is that of the slopes themselves.
constexpr int spin_frequency = 3;

/// Directions spread evenly over the sphere on a spiral. On no axis or diagonal of a body: turned by angles that are no nice ones.
std::vector<Vector3d> spiral(int count, double turn) {
  const Eigen::Matrix3d turned =
      (Eigen::AngleAxisd(turn, Vector3d(0.3, 0.5, 0.8).normalized()) * Eigen::AngleAxisd(0.7, Vector3d::UnitX())).toRotationMatrix();
  std::vector<Vector3d> list;
  for (int k = 0; k < count; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / count, angle = k * std::numbers::pi * (3.0 - std::sqrt(5.0)), r = std::sqrt(1.0 - z * z);
    list.push_back(turned * Vector3d(r * std::cos(angle), r * std::sin(angle), z));
  }
  return list;
}

/// The model about the centre, in coefficients: of density/2 |u|^2 A and L, speeds u and L omega of order 1.
class Truth {
 public:
  Truth(const Surface& surface, const Model& model) : surface_(surface), model_(model) { model_.quadrature = Quadrature::six; }

  Vector6d operator()(const Vector3d& u, const Vector3d& turned) const {
    // Spin as that of the body: the same as the air's turning the other way.
    const Wrench w = wrench(surface_, {.wind = u, .angular_velocity = turned / surface_.radius, .reference_point = surface_.centre},
                            {.density = 2.0 / surface_.total_area}, model_)
                         .total();
    return (Vector6d() << w.force, w.torque / surface_.radius).finished();
  }

 private:
  const Surface& surface_;
  Model model_;
};

/// @param rows  of a direction: as many as `columns`
DirectionMap sampled(int frequency, int columns, const std::function<std::vector<Vector6d>(const Vector3d&)>& rows) {
  DirectionMap map = DirectionMap::zero(frequency, columns);
  for (int node = 0; node < map.nodes(); ++node) {
    const std::vector<Vector6d> found = rows(map.direction(node));
    for (int column = 0; column < columns; ++column) {
      const Vector6d& one = found[static_cast<std::size_t>(column)];
      map.set(node, column, one.head<3>(), one.tail<3>());
    }
  }
  return map;
}

/// Slopes along the three axes.
std::vector<Vector6d> slopes(double step, const std::function<Vector6d(const Vector3d&)>& of) {
  std::vector<Vector6d> rows;
  for (int k = 0; k < 3; ++k) rows.push_back((of(step * Vector3d::Unit(k)) - of(-step * Vector3d::Unit(k))) / (2.0 * step));
  return rows;
}

DirectionMap rate_map(const Truth& truth) {
  return sampled(spin_frequency, 3,
                 [&](const Vector3d& u) { return slopes(spin_step, [&](const Vector3d& turned) { return truth(u, turned); }); });
}

DirectionMap tumble_map(const Truth& truth) {
  return sampled(spin_frequency, 4, [&](const Vector3d& turned) {
    std::vector<Vector6d> rows = slopes(flow_step, [&](const Vector3d& u) { return truth(u, turned); });
    rows.insert(rows.begin(), truth(Vector3d::Zero(), turned));
    return rows;
  });
}

struct Case {
  Motion motion;
  Vector6d truth;
};

Case made_case(const Surface& surface, const Truth& truth, const Vector3d& u, const Vector3d& turned) {
  return {{.wind = u, .angular_velocity = turned / surface.radius, .reference_point = surface.centre}, truth(u, turned)};
}

double rms_force(const std::vector<Case>& cases) {
  double squares = 0.0;
  for (const Case& one : cases) squares += one.truth.head<3>().squaredNorm();
  return std::sqrt(squares / static_cast<double>(cases.size()));
}

BakeError error_of(const BakedBody& body, const std::vector<Case>& cases) {
  BakeError error;
  const double unit = rms_force(cases);
  if (!(unit > 0.0)) return error;
  for (const Case& one : cases) {
    const Wrench baked = wrench(body, one.motion, {.density = 2.0 / body.area});
    const double force = (baked.force - one.truth.head<3>()).norm() / unit,
                 torque = (baked.torque / body.length - one.truth.tail<3>()).norm() / unit;
    error.rms_force += force * force, error.rms_torque += torque * torque;
    error.worst_force = std::max(error.worst_force, force), error.worst_torque = std::max(error.worst_torque, torque);
  }
  error.rms_force = std::sqrt(error.rms_force / static_cast<double>(cases.size()));
  error.rms_torque = std::sqrt(error.rms_torque / static_cast<double>(cases.size()));
  return error;
}

/// 64-bit FNV-1a over numbers.
class Hash {
 public:
  void add(std::uint64_t word) {
    for (int byte = 0; byte < 8; ++byte) value_ = (value_ ^ (word >> (8 * byte) & 0xffu)) * 1099511628211ull;
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number + 0.0)); }  // -0 is 0
  template <class Numbers>
  void add_all(const Numbers& numbers) {
    for (const auto& number : numbers) add(static_cast<double>(number));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037ull;
};

std::uint64_t hash_of(const Surface& surface) {
  Hash hash;
  for (const Eigen::ArrayX3d* array : {&surface.normal, &surface.centroid, &surface.edge_ab, &surface.edge_ac})
    hash.add_all(array->reshaped());
  for (const Eigen::ArrayXd* array : {&surface.area, &surface.back}) hash.add_all(array->reshaped());
  for (const auto* tensors : {&surface.second_moment, &surface.curvature}) hash.add_all(tensors->reshaped());
  hash.add_all(surface.part);
  for (const Part& part : surface.parts) {
    hash.add(static_cast<double>(part.body_class));
    hash.add(part.volume);
  }
  if (!surface.exposure) return hash.value();
  for (const Vector3d& direction : surface.exposure->directions) hash.add_all(direction);
  hash.add_all(surface.exposure->row);
  hash.add_all(surface.exposure->reached.reshaped());
  return hash.value();
}

void add(Hash& hash, const Law& law, const Pillow& pillow) {
  hash.add_all(law.windward);
  hash.add_all(law.leeward);
  hash.add_all(std::array{law.friction, law.base_suction, law.base_edge, law.aspect_gain, law.aspect_scale, law.recovery,
                          law.recovery_depth, law.recovery_edge, law.shelter, law.curvature});
  hash.add_all(std::array{static_cast<double>(pillow.form), pillow.factor, static_cast<double>(pillow.falloff)});
}

std::uint64_t hash_of(const Model& model) {
  Hash hash;
  add(hash, model.law, model.pillow);
  if (model.sheets) add(hash, model.sheets->law, model.sheets->pillow);
  hash.add(std::uint64_t{model.effects.bits()});
  if (model.correction) hash.add_all(model.correction->map.values);
  return hash.value();
}

std::string described(const Law& law, const Pillow& pillow) {
  std::ostringstream text;
  text << "law " << (law.name.empty() ? "without name" : law.name);
  const auto polynomial = [&text](const char* name, const Law::Polynomial& coefficients) {
    text << ", " << name;
    for (const double c : coefficients) text << " " << c;
  };
  polynomial("windward", law.windward);
  polynomial("leeward", law.leeward);
  for (const auto& [name, value] : {std::pair{"friction", law.friction},
                                    {"base suction", law.base_suction},
                                    {"base edge", law.base_edge},
                                    {"aspect gain", law.aspect_gain},
                                    {"aspect scale", law.aspect_scale},
                                    {"recovery", law.recovery},
                                    {"recovery depth", law.recovery_depth},
                                    {"recovery edge", law.recovery_edge},
                                    {"shelter", law.shelter},
                                    {"curvature", law.curvature}})
    text << ", " << name << " " << value;
  text << "; pillow " << to_string(pillow.form);
  if (pillow.form != PillowForm::none) text << " " << pillow.factor << " " << to_string(pillow.falloff);
  return text.str();
}

std::string described(const Model& model) {
  std::string text = described(model.law, model.pillow);
  if (model.sheets) text += "; on sheets " + described(model.sheets->law, model.sheets->pillow);
  if (model.correction) text += "; correction of " + model.correction->origin;
  if (model.effects != Effects::all()) text += "; effects " + std::to_string(model.effects.bits());
  return text;
}

std::string percent(double share) {
  std::ostringstream text;
  text.precision(2);
  text << 100.0 * share << " %";
  return text.str();
}

}  // namespace

std::size_t BakedBody::bytes() const { return sizeof(float) * (steady.values.size() + rate.values.size() + tumble.values.size()); }

bool BakedBody::matches(const Surface& surface, const Model& given) const {
  return surface_hash == hash_of(surface) && model_hash == hash_of(given);
}

BakedBody bake(const Surface& surface, const Model& model, const BakeOptions& options) {
  require(options.rms_error >= 0.0 && options.rms_error < 1.0, "bake: rms_error", options.rms_error,
          "it must be from 0 to below 1; 0.01 is 1 %");
  require(surface.size() > 0, "bake: triangles of the surface", surface.size(), "at least one with an area is needed");
  BakedBody body{.centre = surface.centre,
                 .area = surface.total_area,
                 .length = surface.radius,
                 .model = described(model),
                 .surface_hash = hash_of(surface),
                 .model_hash = hash_of(model)};
  const Truth truth(surface, model);
  std::vector<Case> at_rest, trial;
  for (const Vector3d& u : spiral(steady_samples, 0.4)) at_rest.push_back(made_case(surface, truth, u, Vector3d::Zero()));
  body.rms_force = rms_force(at_rest);
  const bool spins = model.effects.has(Effect::spin);
  if (spins) {
    body.rate = rate_map(truth);
    body.tumble = tumble_map(truth);
  }
  // Upwards until the error is small enough, or the next map too large. What was reached is said where that is not enough.
  BakedBody best = body;
  bool reached = false;
  for (const int frequency : frequencies) {
    const std::size_t needed = body.bytes() + sizeof(float) * 8u * (2u * frequency + 1u) * (2u * frequency + 1u);
    if (needed > options.most_bytes) break;
    best.steady = sampled(frequency, 1, [&](const Vector3d& u) { return std::vector{truth(u, Vector3d::Zero())}; });
    best.error = error_of(best, at_rest);
    reached = best.error.rms() <= options.rms_error;
    if (reached) break;
  }
  require(best.steady.frequency > 0, "bake: most_bytes", options.most_bytes,
          [&] { return "the smallest map of this body takes " + std::to_string(body.bytes() + 800) + " bytes"; });
  require(reached || options.rms_error == 0.0, "bake: rms_error", options.rms_error, [&] {
    return "within " + std::to_string(options.most_bytes) + " bytes it is " + percent(best.error.rms()) +
           " of the rms force: allow more bytes or a larger error";
  });
  const std::vector<Vector3d> flows = spiral(spin_samples, 1.1), spins_about = spiral(spin_samples, 2.3);
  for (std::size_t k = 0; spins && k < body.spin_ratios.size(); ++k) {
    trial.clear();
    // Pairs that have nothing to do with each other: 107 and 300 have no common divisor.
    for (std::size_t i = 0; i < flows.size(); ++i)
      trial.push_back(made_case(surface, truth, flows[i], body.spin_ratios[k] * spins_about[107 * i % spins_about.size()]));
    best.spin_error[k] = error_of(best, trial);
  }
  return best;
}

}  // namespace dragcore
