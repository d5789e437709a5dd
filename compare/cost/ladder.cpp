#include "compare/cost/ladder.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#ifdef DRAGCORE_THREADS
#include <tbb/task_arena.h>
#endif

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <dragcore/bake.hpp>
#include <dragcore/batch.hpp>
#include <dragcore/stepping.hpp>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>

#include "compare/calibration/prediction.hpp"
#include "compare/peers/peers.hpp"
#include "compare/reference/case_of_record.hpp"
#include "compare/reference/coefficients.hpp"
#include "compare/tables/error_table.hpp"
#include "compare/tables/spin_table.hpp"
#include "compare/tables/variants.hpp"

namespace compare {
namespace {

using case_record::CaseRecord;
using dragcore::Effect;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Channels = CaseRecord::Channels;

/// Where a body stands in the wind, and what the truth is there.
struct Place {
  const CaseRecord* record;
  std::string body;  ///< its label
  Matrix3d to_wind;
  dragcore::Motion motion;
  Channels scales, truth, u;  ///< coefficients, but for the scales
  Channels u_numerical;       ///< all of u where the part of the mesh is not known by itself
  double body_force = 0.0;    ///< rms |(C_D, C_S, C_L)| of the body's poses
};

std::vector<Place> places_of(const std::vector<CaseOfRecord>& cases, const std::string& only) {
  std::vector<Place> places;
  std::set<std::string> known;
  for (const CaseOfRecord& chosen : cases) {
    const CaseRecord& record = *chosen.family.record;
    if (!case_record::is_usable(record.status) || flow_class(record) == "laminar" || record.reynolds < 1e4 || record.spins()) continue;
    if (!record.knows_force() || !record.knows_moment()) continue;
    Place place{&record, shape_label(record.shape), record.pose.rotation(), motion_of(record)};
    known.insert(place.body);
    if (place.body.find(only) == std::string::npos) continue;
    place.scales = coefficient_scales(record);
    place.truth << record.load.force(), record.load.moment();
    place.truth = place.truth.cwiseQuotient(place.scales);
    const LoadUncertainty& u = chosen.family.uncertainty;
    place.u = u.total.cwiseQuotient(place.scales);
    place.u_numerical = u.discretisation_assessed ? Channels(u.numerical.cwiseQuotient(place.scales)) : place.u;
    places.push_back(place);
  }
  if (places.empty() && !known.empty())
    throw std::invalid_argument(fmt::format("no reference has the body '{}'; known are {}", only, fmt::join(known, ", ")));
  std::map<std::string, std::pair<double, int>> squares;
  for (const Place& place : places) {
    auto& [sum, n] = squares[place.body];
    sum += place.truth.head<3>().squaredNorm(), ++n;
  }
  for (Place& place : places) place.body_force = std::sqrt(squares.at(place.body).first / squares.at(place.body).second);
  return places;
}

/// Sums of squares, one pose after the other.
class Tally {
 public:
  void add(const Place& place, const Channels& error) {
    sums_.drag += error[0] * error[0];
    sums_.force += error.head<3>().squaredNorm();
    sums_.torque += error.tail<3>().squaredNorm();
    sums_.relative += error.head<3>().squaredNorm() / (place.body_force * place.body_force);
    ++n_;
  }
  int n() const { return n_; }
  RmsErrors rms() const {
    const auto root = [&](double sum) { return std::sqrt(sum / n_); };
    return {root(sums_.relative), root(sums_.drag), root(sums_.force), root(sums_.torque)};
  }

 private:
  RmsErrors sums_;
  int n_ = 0;
};

double cpu_now() {
  std::timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double wall_now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Seconds of a call: the best of several batches, each long enough for the clock. What else the machine does only ever adds.
double seconds_of(const std::function<void()>& call, bool quick, double (*now)() = cpu_now) {
  const auto batch_of = [&](int calls) {
    const double start = now();
    for (int i = 0; i < calls; ++i) call();
    return (now() - start) / calls;
  };
  const double first = std::max(batch_of(1), 1e-9);
  const int calls = std::clamp(static_cast<int>((quick ? 2e-4 : 2e-3) / first), 1, 100000);
  double best = std::numeric_limits<double>::infinity();
  for (int batch = 0; batch < (quick ? 3 : 7); ++batch) best = std::min(best, batch_of(calls));
  return best;
}

/// The work on so many threads, where the library has any.
std::function<void()> on_threads([[maybe_unused]] int threads, const std::function<void()>& work) {
#ifdef DRAGCORE_THREADS
  return [arena = std::make_shared<tbb::task_arena>(threads), work] { arena->execute(work); };
#else
  return work;
#endif
}

/// A way to answer, ready at every place: force and torque in the body frame.
struct Candidate {
  std::string name, kind;
  std::vector<std::function<dragcore::Wrench()>> answers = {};
  double triangles = 0.0;               ///< sum over the places
  std::function<void()> together = {};  ///< where it answers all places at once: what is timed
  int times = 1;                        ///< how often that answers each
};

class Measurement {
 public:
  Measurement(const std::vector<CaseRecord>& records, const LadderOptions& options)
      : options_(options), cases_(cases_of_record(records)), places_(places_of(cases_, options.body)) {
    ladder_.body = options.body;
    ladder_.poses = static_cast<int>(places_.size());
    std::set<std::string> bodies;
    Tally u;
    for (const Place& place : places_) {
      bodies.insert(place.body);
      u.add(place, place.u);
    }
    ladder_.bodies = static_cast<int>(bodies.size());
    if (!places_.empty()) ladder_.uncertainty = u.rms();
  }

  Ladder run() {
    if (places_.empty()) return ladder_;
    constants();
    engines();
    laws();
    batch();
    if (!options_.quick) baked();
    ablation();
    meshes();
    steps();
    spin();
    cfd();
    stopping();
    return ladder_;
  }

 private:
  Rung measured(const Candidate& candidate) const {
    Tally errors;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Place& place = places_[i];
      const dragcore::Wrench wrench = candidate.answers[i]();
      Channels load;
      load << place.to_wind * wrench.force, place.to_wind * wrench.torque;
      errors.add(place, load.cwiseQuotient(place.scales) - place.truth);
    }
    const auto one_by_one = [&] {
      for (const auto& answer : candidate.answers) answer();
    };
    const double sweep = seconds_of(candidate.together ? candidate.together : one_by_one, options_.quick) / candidate.times;
    const auto n = static_cast<double>(places_.size());
    return {candidate.name, candidate.kind, candidate.triangles / n, sweep / n, errors.rms(), errors.n()};
  }

  void add(const Candidate& candidate) { ladder_.rungs.push_back(measured(candidate)); }

  /// C_D times the area: no shape, no direction.
  void constants() {
    double sum = 0.0;
    std::map<std::string, std::pair<double, int>> of_body;
    for (const Place& place : places_) {
      sum += place.truth[0];
      of_body[place.body].first += place.truth[0], ++of_body[place.body].second;
    }
    Candidate one{"one C_D for all", "constant"}, own{"C_D of the body", "constant"};
    const auto answer = [](const Place& place, double coefficient) {
      const double area = dragcore::properties(place.record->shape).reference_area;
      return [wind = place.motion.wind, factor = 0.5 * place.record->density * area * coefficient] {
        return dragcore::Wrench{factor * wind.norm() * wind, Vector3d::Zero()};
      };
    };
    for (const Place& place : places_) {
      const double all = sum / static_cast<double>(places_.size());
      const auto& [total, n] = of_body.at(place.body);
      // Of the body's other poses: a mean that holds this one would know it beforehand.
      one.answers.push_back(answer(place, all));
      own.answers.push_back(answer(place, n > 1 ? (total - place.truth[0]) / (n - 1) : all));
    }
    add(one);
    add(own);
  }

  void engines() {
    for (const peers::Engine& engine : peers::engines()) {
      Candidate candidate{engine.name, "engine"};
      std::map<std::string, std::shared_ptr<peers::Peer>> bodies;
      for (const Place& place : places_) {
        const dragcore::TriangleMesh mesh = dragcore::triangulate(place.record->shape, divisions(place, 8));
        auto& body = bodies[place.body + fmt::format(" {}", place.record->density)];
        if (!body) body = engine.make(mesh, place.record->density);
        if (engine.reads_triangles) candidate.triangles += static_cast<double>(mesh.triangles.size());
        candidate.answers.emplace_back([body, wind = place.motion.wind] { return body->wrench(wind); });
      }
      add(candidate);
    }
  }

  /// Those of default_divisions(), or less.
  static int divisions(const Place& place, int most) { return std::min(most, default_divisions(place.record->shape)); }

  Candidate law(const std::string& name, const ModelChoice& choice, int most = 1000) const {
    Candidate candidate{name, "law"};
    for (const Place& place : places_) {
      const dragcore::Surface& surface = prepared_surface(place.record->shape, divisions(place, most));
      candidate.triangles += static_cast<double>(surface.size());
      candidate.answers.emplace_back([&surface, &motion = place.motion, medium = dragcore::Medium{place.record->density},
                                      model = choice.on(surface)] { return wrench(surface, motion, medium, model).total(); });
    }
    return candidate;
  }

  static ModelChoice single(ModelChoice choice) {
    choice.model.precision = dragcore::Precision::single;
    return choice;
  }

  void laws() {
    const auto fixed = [](const dragcore::Law& pressure, const dragcore::Pillow& pillow = {}) {
      return single(dragcore::Model{.law = pressure, .pillow = pillow});
    };
    add(law("note", fixed(dragcore::note_law())));
    add(law("consistent", fixed(dragcore::consistent_law())));
    if (options_.calibration) {
      const dragcore::Law scaled = options_.calibration->fits.front().model.law;
      add(law("scaled", fixed(scaled)));
      for (const char* form : {"triangle", "patch", "tilt"})
        add(law(fmt::format("note, {} pillow", form),
                fixed(dragcore::note_law(), options_.calibration->fit(fmt::format("pillow {} on law note", form)).model.pillow)));
    }
    add(law("class", single(ModelChoice::of_class())));
    const ModelChoice best = single(ModelChoice::recommended());
    add(law(best_law, best));
    add(law(fmt::format("{}, in double", best_law), ModelChoice::recommended()));
    for (const int most : options_.quick ? std::vector{1} : std::vector{1, 2, 4, 8, 16})
      add(law(fmt::format("{}, n = {}", best_law, most), best, most));
  }

  /// Bodies of a shape side by side, one a lane; by the clock on one thread and on two.
  void batch() {
    constexpr int copies = 16, most = 4;
    Candidate candidate{fmt::format("{}, n = {}, in a batch", best_law, most), "law"};
    const double density = places_.front().record->density;  // one air for all
    std::vector<dragcore::Model> models;
    models.reserve(places_.size());
    std::vector<dragcore::BodyInFlow> bodies;
    for (const Place& place : places_) {
      const dragcore::Surface& surface = prepared_surface(place.record->shape, divisions(place, most));
      candidate.triangles += static_cast<double>(surface.size());
      models.push_back(single(ModelChoice::recommended()).on(surface));
      bodies.insert(bodies.end(), copies, {&surface, &models.back(), place.motion});
    }
    std::vector<dragcore::Wrench> results(bodies.size());
    const auto all = [&] { wrenches(bodies, {density}, results); };
    all();
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const double share = places_[i].record->density / density;
      const dragcore::Wrench& found = results[copies * i];
      candidate.answers.emplace_back([wrench = dragcore::Wrench{share * found.force, share * found.torque}] { return wrench; });
    }
    candidate.times = copies;
    candidate.together = on_threads(1, all);
    add(candidate);
    const auto n = static_cast<double>(places_.size());
    for (const int threads : {1, 2})
      ladder_.steps.push_back(
          {fmt::format("wrench in a batch of {:.0f}, {} thread{}, by the clock", copies * n, threads, threads > 1 ? "s" : ""), "all",
           candidate.triangles / n, seconds_of(on_threads(threads, all), options_.quick, wall_now) / (copies * n)});
  }

  /// The same law as maps over direction, by how wrong they may be; without spin, which no pose here has.
  void baked() {
    for (const double error : {0.1, 0.03, 0.01}) {
      Candidate candidate{fmt::format("{}, baked to {:.0f} %", best_law, 100.0 * error), "law"};
      std::map<const dragcore::Surface*, std::shared_ptr<const dragcore::BakedBody>> bodies;
      for (const Place& place : places_) {
        const dragcore::Surface& surface = prepared_surface(place.record->shape, divisions(place, 1000));
        auto& body = bodies[&surface];
        if (!body) {
          dragcore::Model model = single(ModelChoice::recommended()).on(surface);
          model.effects = model.effects.without(Effect::spin);
          body = std::make_shared<const dragcore::BakedBody>(bake(surface, model, {.rms_error = error, .most_bytes = 1u << 20}));
        }
        candidate.triangles += static_cast<double>(surface.size());
        candidate.answers.emplace_back(
            [body, &motion = place.motion, medium = dragcore::Medium{place.record->density}] { return wrench(*body, motion, medium); });
      }
      add(candidate);
    }
  }

  /// A law that was fitted whole is worse off without a part than one fitted without it: what is found is what the part does here.
  void ablation() {
    for (const Effect effect :
         {Effect::base_suction, Effect::recovery, Effect::shelter, Effect::curvature, Effect::friction, Effect::pillow}) {
      ModelChoice choice = single(ModelChoice::recommended());
      choice.model.effects = dragcore::Effects::all().without(effect);
      const Rung rung = measured(law("", choice));
      ladder_.ablation.push_back({to_string(effect), rung.errors, rung.seconds});
    }
  }

  /// Drag along x of round bodies, up to some 100,000 triangles.
  void meshes() {
    for (const dragcore::Shape& shape :
         {dragcore::Shape(dragcore::Cone{}), dragcore::Shape(dragcore::Sphere{}), dragcore::Shape(dragcore::Cylinder{})}) {
      const std::size_t first = ladder_.meshes.size();
      std::vector<double> drag;
      for (int n = 1, finest = options_.quick ? 16 : 64; n <= finest; n *= 2) {
        const dragcore::Surface surface = surface_of(shape, n);
        const dragcore::Model model = dragcore::model_for(surface);
        const dragcore::Motion motion{.wind = {1.0, 0.0, 0.0}};
        drag.push_back(wrench(surface, motion, {}, model).total().force.x());
        ladder_.meshes.push_back({dragcore::kind(shape), static_cast<double>(surface.size()),
                                  seconds_of([&] { wrench(surface, motion, {}, model); }, options_.quick)});
      }
      for (std::size_t i = 0; i < drag.size(); ++i) ladder_.meshes[first + i].force_ratio = drag[i] / drag.back();
    }
  }

  void steps() {
    for (const auto& [shape, n] : {std::pair(dragcore::Shape(dragcore::Box{}), 1), std::pair(dragcore::Shape(dragcore::Sphere{}), 16)}) {
      const dragcore::Surface surface = surface_of(shape, n);
      const dragcore::Model model = dragcore::model_for(surface);
      const dragcore::Motion motion{.wind = {1.0, 0.3, 0.2}, .angular_velocity = {0.5, 0.3, 0.4}};
      dragcore::MassProperties body;
      body.mass = 1.0, body.inertia = 0.1 * Matrix3d::Identity();
      const auto add_step = [&](const char* what, const std::function<void()>& call) {
        ladder_.steps.push_back({what, dragcore::kind(shape), static_cast<double>(surface.size()), seconds_of(call, options_.quick)});
      };
      add_step("wrench, spinning", [&] { wrench(surface, motion, {}, model); });
      add_step("resistance", [&] { resistance(surface, motion, {}, model); });
      add_step("resistance and a step",
               [&] { step_secant_implicit(resistance(surface, motion, {}, model), body, motion, dragcore::Vector6d::Zero(), 1.0 / 60.0); });
    }
  }

  void spin() {
    std::vector<CaseRecord> cases;
    for (const CaseRecord& record : options_.spinning)
      if (record.reynolds >= 1e4 && case_record::is_usable(record.status)) cases.push_back(record);
    if (cases.empty()) return;
    const auto torques = [&](const ModelChoice& choice) {
      std::vector<double> values;
      for (const CaseRecord& record : cases) {
        const dragcore::Wrench predicted = predict(record, choice).total();
        values.push_back(predicted.torque.dot(record.angular_velocity.normalized()) / coefficient_scales(record)[3]);
      }
      return values;
    };
    ModelChoice choice = ModelChoice::recommended();
    choice.model.quadrature = dragcore::Quadrature::six;
    const std::vector<double> six = torques(choice);
    for (const auto& [name, order] :
         {std::pair("1 point", dragcore::Quadrature::one), std::pair("3 points", dragcore::Quadrature::three),
          std::pair("6 points", dragcore::Quadrature::six), std::pair("adaptive", dragcore::Quadrature::adaptive)}) {
      choice.model.quadrature = order;
      SpinStep step{.rule = name};
      const std::vector<double> found = torques(choice);
      double size = 0.0;
      for (std::size_t i = 0; i < six.size(); ++i) {
        step.rule_error += std::pow(found[i] - six[i], 2);
        size += six[i] * six[i];
      }
      step.rule_error = std::sqrt(step.rule_error / size);
      double error = 0.0, cfd = 0.0;
      for (const SpinRow& row : spin_table(cases, predictor(choice)))
        if (row.error) {
          error += *row.error * *row.error, cfd += *row.cfd * *row.cfd;
          ++step.cases;
        }
      step.cfd_error = std::sqrt(error / cfd);
      std::vector<std::function<void()>> calls;
      const ModelChoice fast = single(choice);
      for (const CaseRecord& record : cases) {
        const dragcore::Surface& surface = prepared_surface(record.shape, default_divisions(record.shape));
        step.triangles += static_cast<double>(surface.size()) / static_cast<double>(cases.size());
        calls.emplace_back([&surface, motion = motion_of(record), model = fast.on(surface)] { wrench(surface, motion, {}, model); });
      }
      const double sweep = seconds_of(
          [&] {
            for (const auto& call : calls) call();
          },
          options_.quick);
      step.seconds = sweep / static_cast<double>(calls.size());
      ladder_.spin.push_back(step);
    }
  }

  /// Every mesh level of every method that solved a pose, where it is not a variant of the numerics.
  void cfd() {
    struct Level {
      Tally errors;
      double seconds = 0.0, cells = 0.0;
    };
    std::map<std::pair<std::string, std::string>, Level> levels;
    std::map<std::string, const Place*> place_of;
    for (const Place& place : places_) place_of[place.record->name] = &place;
    for (const CaseOfRecord& chosen : cases_) {
      const auto found = place_of.find(chosen.family.record->name);
      if (found == place_of.end()) continue;
      const Place& place = *found->second;
      std::vector<const CaseFamily*> families = {&chosen.family};
      for (const CaseFamily& other : chosen.alternatives) families.push_back(&other);
      for (const CaseFamily* family : families)
        for (const CaseRecord* record : family->usable_levels()) {
          double seconds = 0.0;
          for (const auto& [stage, cost] : record->cost) seconds += cost.cpu_s;
          if (!(seconds > 0.0)) continue;  // from elsewhere: nobody knows
          Channels load;
          load << record->load.force(), record->load.moment();
          Level& level = levels[{record->flow_model, record->mesh_level}];
          Channels error = load.cwiseQuotient(place.scales) - place.truth;
          // A level of the same method shares what is unknown of the record's own mesh; one of another method does not.
          if (record->flow_model == place.record->flow_model) error = (error.cwiseAbs2() + place.u_numerical.cwiseAbs2()).cwiseSqrt();
          level.errors.add(place, error);
          level.seconds += seconds;
          level.cells += record->cells;
        }
    }
    for (const auto& [name, level] : levels) {
      const double n = level.errors.n();
      ladder_.rungs.push_back(
          {name.first + ", " + name.second, "CFD", level.cells / n, level.seconds / n, level.errors.rms(), level.errors.n()});
    }
  }

  void stopping() {
    Stopping& stop = ladder_.stopping;
    double squares = 0.0;
    for (const Place& place : places_) {
      if (place.record->flow_model.ends_with("_ddes") || place.record->is_experiment()) continue;
      const double left = place.record->u_iteration.head<3>().norm() / place.record->load.force().norm();
      squares += left * left;
      ++stop.poses;
    }
    if (stop.poses > 0) stop.left = std::sqrt(squares / stop.poses);
    for (const VariantRow& row : variant_table(options_.studies).rows) {
      if (row.variant != "iterations-800" || !row.cpu_ratio || !row.drag.percent) continue;
      stop.longer_cost_low = std::min(stop.longer_cost_low.value_or(*row.cpu_ratio), *row.cpu_ratio);
      stop.longer_cost_high = std::max(stop.longer_cost_high.value_or(*row.cpu_ratio), *row.cpu_ratio);
      stop.longer_change = std::max(stop.longer_change, 0.01 * std::abs(*row.drag.percent));
    }
  }

  const LadderOptions& options_;
  std::vector<CaseOfRecord> cases_;
  std::vector<Place> places_;
  Ladder ladder_;
};

}  // namespace

const Rung* Ladder::rung(const std::string& name) const {
  const auto found = std::find_if(rungs.begin(), rungs.end(), [&](const Rung& rung) { return rung.name == name; });
  return found == rungs.end() ? nullptr : &*found;
}

Ladder measure_ladder(const std::vector<CaseRecord>& records, const LadderOptions& options) { return Measurement(records, options).run(); }

}  // namespace compare
