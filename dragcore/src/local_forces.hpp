#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dragcore/descriptors.hpp>
#include <dragcore/drag.hpp>
#include <optional>
#include <vector>

#include "instrument.hpp"
#include "quadrature.hpp"

namespace dragcore {

/// cross_matrix(a) b = a x b.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  return (Eigen::Matrix3d() << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0).finished();
}

/// Which effects this evaluation has: allowed by the model, part of the law, the pillow and the motion, and built.
class ActiveEffects {
 public:
  ActiveEffects(const Motion& motion, const Model& model) {
    const Law& law = model.law;
    const auto any = [](const Law::Polynomial& p) { return std::any_of(p.begin(), p.end(), [](double x) { return x != 0.0; }); };
    set(Effect::leeward_suction, any(law.leeward), model);
    set(Effect::friction, law.friction != 0.0, model);
    set(Effect::base_suction, law.base_suction != 0.0, model);
    set(Effect::recovery, law.base_suction * law.recovery != 0.0, model);
    set(Effect::shelter, law.shelter != 0.0, model);
    set(Effect::curvature, law.curvature != 0.0, model);
    set(Effect::pillow,
        model.pillow.form != PillowForm::none && (model.pillow.factor > 0.0 || model.pillow.form == PillowForm::eccentricity), model);
    set(Effect::spin, !motion.angular_velocity.isZero(0.0), model);
    set(Effect::wind_variation, !motion.triangle_wind.empty() || !motion.wind_gradient.isZero(0.0), model);
  }

  template <Effect effect>
  bool has() const {
    if constexpr (!instrument::built(effect)) return false;
    return on_.has(effect);
  }

 private:
  void set(Effect effect, bool called_for, const Model& model) {
    if (called_for && model.effects.has(effect)) on_ = on_ | effect;
  }
  Effects on_;
};

/// Velocity of the air relative to the points of a surface: eq. 1.
class RelativeFlow {
 public:
  RelativeFlow(const Surface& surface, const Motion& motion, const ActiveEffects& active)
      : motion_(motion),
        spin_(active.has<Effect::spin>()),
        per_triangle_(false),
        gradient_(false),
        uniform_(motion.wind - motion.velocity),
        centre_(uniform_) {
    if (active.has<Effect::wind_variation>()) {
      per_triangle_ = !motion.triangle_wind.empty();
      gradient_ = !per_triangle_ && !motion.wind_gradient.isZero(0.0);
    }
    if (per_triangle_) {
      patch_wind_.assign(surface.patches.size(), Eigen::Vector3d::Zero());
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (Eigen::Index i = 0; i < surface.size(); ++i) {
        instrument::count(Effect::wind_variation);
        const Eigen::Vector3d share = surface.area[i] * motion.triangle_wind[static_cast<std::size_t>(i)];
        patch_wind_[patch_of(surface, i)] += share;
        sum += share;
      }
      for (std::size_t p = 0; p < patch_wind_.size(); ++p) patch_wind_[p] /= surface.patches[p].area;
      if (surface.size() > 0) centre_ = sum / surface.total_area - motion.velocity;
    }
    centre_ = moved(centre_, surface.centre);
    // Of the relative flow: its rate of strain, and its turning. Air that turns with the body does not vary.
    Eigen::Vector3d turning = Eigen::Vector3d::Zero();
    if (spin_) turning = motion.angular_velocity;
    if (gradient_) {
      const Eigen::Matrix3d& G = motion.wind_gradient;
      turning -= 0.5 * Eigen::Vector3d(G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1));
      variation_ = 0.5 * (G + G.transpose()).norm();
    }
    variation_ += turning.norm();
  }

  static std::size_t patch_of(const Surface& surface, Eigen::Index triangle) {
    return static_cast<std::size_t>(surface.patch[static_cast<std::size_t>(triangle)]);
  }

  /// At a point of a triangle, of a patch, and at the surface's centre.
  Eigen::Vector3d at(const Eigen::Vector3d& r, Eigen::Index triangle) const {
    return moved(per_triangle_ ? Eigen::Vector3d(motion_.triangle_wind[static_cast<std::size_t>(triangle)] - motion_.velocity) : uniform_,
                 r);
  }
  Eigen::Vector3d at_patch(const Patch& patch, std::size_t index) const {
    return moved(per_triangle_ ? Eigen::Vector3d(patch_wind_[index] - motion_.velocity) : uniform_, patch.centroid);
  }
  const Eigen::Vector3d& at_centre() const { return centre_; }

  /// Whether the velocity differs between the points of one triangle, and a bound of how much per metre.
  bool varies_on_triangles() const { return spin_ || gradient_; }
  bool varies() const { return varies_on_triangles() || per_triangle_; }
  double variation_per_metre() const { return variation_; }

 private:
  Eigen::Vector3d moved(Eigen::Vector3d u, const Eigen::Vector3d& r) const {
    const Eigen::Vector3d arm = r - motion_.reference_point;
    if (gradient_) {
      instrument::count(Effect::wind_variation);
      u += motion_.wind_gradient * arm;
    }
    if (spin_) {
      instrument::count(Effect::spin);
      u -= motion_.angular_velocity.cross(arm);
    }
    return u;
  }

  const Motion& motion_;
  bool spin_, per_triangle_, gradient_;
  Eigen::Vector3d uniform_, centre_;
  std::vector<Eigen::Vector3d> patch_wind_;
  double variation_ = 0.0;
};

/// A function of c and its derivative.
struct Curve {
  double value = 0.0, slope = 0.0;
  Curve operator*(const Curve& other) const { return {value * other.value, slope * other.value + value * other.slope}; }
  Curve operator*(double factor) const { return {value * factor, slope * factor}; }
};

/// c (1 + e)/(c + e): 0 at 0, 1 at 1, most of its rise below c = e.
inline Curve saturating(double c, double e) { return {c * (1.0 + e) / (c + e), (1.0 + e) * e / ((c + e) * (c + e))}; }

/// The law as one body sees it in one flow: descriptors worked in. Eq. 7 to 12.
class BodyLaw {
 public:
  BodyLaw(const Surface& surface, const Law& law, const RelativeFlow& flow, const ActiveEffects& active) : law_(law), active_(active) {
    const bool aspect = active.has<Effect::base_suction>() && law.aspect_gain != 0.0;
    if (!aspect && !active.has<Effect::recovery>() && !active.has<Effect::shelter>()) return;
    const Descriptors body = describe(surface, flow.at_centre());
    // A spinning body has no one direction of flow: what depends on it fades as the spin takes over, and a tumbling body is left with the
    // local terms.
    const double travel = flow.at_centre().squaredNorm(), turning = flow.variation_per_metre() * surface.radius;
    const double directed = travel > 0.0 ? travel / (travel + turning * turning) : 0.0;
    if (aspect)
      aspect_factor_ +=
          directed * law.aspect_gain * body.aspect * body.aspect / (body.aspect * body.aspect + law.aspect_scale * law.aspect_scale);
    if (active.has<Effect::recovery>()) {
      instrument::count(Effect::recovery);
      push_ = directed * law.base_suction * law.recovery * body.depth / (body.depth + law.recovery_depth);
    }
    if (active.has<Effect::shelter>()) {
      instrument::count(Effect::shelter);
      sharpness_ = body.sharpness;
      shelter_ = directed * law.shelter * std::pow(body.sharpness, 4);
    }
  }

  /// Visits (term, coefficient and slope) of everything that windward surface feels along its inward normal. `chi` is called only where it
  /// counts.
  template <class Chi, class Visit>
  void windward(double c, Chi&& chi, Visit&& visit) const {
    Curve shelter{1.0, 0.0};
    if (active_.has<Effect::shelter>() && sharpness_ > 0.0) {
      instrument::count(Effect::shelter);
      // p(x) = x^2/(x + 0.1) for x > 0: a smooth start of the ramp.
      if (const double x = 1.0 - c / sharpness_; x > 0.0) {
        const double ramp = x * x / (x + 0.1), ramp_slope = (x * x + 0.2 * x) / ((x + 0.1) * (x + 0.1));
        const double value = std::exp(-shelter_ * ramp);
        shelter = {value, value * shelter_ * ramp_slope / sharpness_};
      }
    }
    visit(Term::windward_pressure, shelter * Curve{evaluate(law_.windward, c), derivative(law_.windward, c)});
    if (active_.has<Effect::base_suction>()) {
      instrument::count(Effect::base_suction);
      visit(Term::base_suction, shelter * (saturating(c, law_.base_edge) * Curve{2.0 - c, -1.0}) * (law_.base_suction * aspect_factor_));
    }
    if (active_.has<Effect::curvature>()) {
      instrument::count(Effect::curvature);
      if (const double factor = chi(); factor > 0.0)
        visit(Term::curvature, shelter * (saturating(c, 0.2) * Curve{1.0 - c * c, -2.0 * c}) * (-law_.curvature * factor));
    }
  }

  /// The same along the outward normal of leeward surface.
  template <class Visit>
  void leeward(double c, Visit&& visit) const {
    if (active_.has<Effect::leeward_suction>()) {
      instrument::count(Effect::leeward_suction);
      visit(Term::leeward_suction, Curve{evaluate(law_.leeward, c), derivative(law_.leeward, c)});
    }
    if (active_.has<Effect::recovery>() && push_ > 0.0) {
      instrument::count(Effect::recovery);
      visit(Term::rear_recovery, saturating(c, law_.recovery_edge) * -push_);
    }
  }

  bool feels_leeward() const { return active_.has<Effect::leeward_suction>() || (active_.has<Effect::recovery>() && push_ > 0.0); }

 private:
  const Law& law_;
  const ActiveEffects& active_;
  double aspect_factor_ = 1.0, push_ = 0.0, shelter_ = 0.0, sharpness_ = 0.0;
};

/// One contribution to the force on a body: one term of the law at one point of the surface. What every sum over a surface is made of.
struct LocalForce {
  Eigen::Index triangle;
  Term term;
  Eigen::Vector3d place;   ///< where it acts, from the reference point [m]
  Eigen::Vector3d normal;  ///< out of the side that feels it
  Eigen::Vector3d u;       ///< velocity of the air relative to the place [m/s]
  double speed;            ///< |u| > 0
  double c;                ///< |u.n| / |u|, in (0, 1]
  double half_rho_area;    ///< rho dA / 2
  Curve coefficient;       ///< of c; negative where it pushes the body through the air

  bool is_friction() const { return term == Term::friction; }
  /// Unit vector of a pressure with a positive coefficient: -normal on windward, +normal on leeward surface.
  Eigen::Vector3d downstream() const { return u.dot(normal) < 0.0 ? Eigen::Vector3d(-normal) : normal; }
  Eigen::Vector3d force() const {
    if (is_friction()) return half_rho_area * speed * coefficient.value * (u - normal * normal.dot(u));
    return half_rho_area * speed * speed * coefficient.value * downstream();
  }
};

/// Where the pillow effect displaces windward pressure.
class PillowShift {
 public:
  PillowShift(const Surface& surface, const RelativeFlow& flow, const Pillow& pillow, const ActiveEffects& active)
      : surface_(surface), flow_(flow), pillow_(pillow), active_(active.has<Effect::pillow>()) {
    if (!active_ || (pillow.form != PillowForm::patch && pillow.form != PillowForm::tilt)) return;
    patches_.reserve(surface.patches.size());
    for (std::size_t p = 0; p < surface.patches.size(); ++p) {
      const Patch& patch = surface.patches[p];
      const Eigen::Vector3d u = flow.at_patch(patch, p);
      if (!surface.two_sided() && !flow.varies() && u.dot(patch.normal) >= 0.0) {
        patches_.emplace_back(Eigen::Vector3d::Zero());  // leeward as a whole: nothing to displace
        continue;
      }
      instrument::count(Effect::pillow);
      const auto falls_off = [&](double alpha) { return patch_pillow_shift(patch, u, alpha, pillow.falloff); };
      const Eigen::Vector3d shift =
          pillow.form == PillowForm::tilt ? tilt_pillow_shift(patch, u, pillow.factor) : faded(u, patch.normal, falls_off);
      patches_.emplace_back(directed(u, patch.second_moment.trace()) * shift);
    }
  }

  Eigen::Vector3d of(Eigen::Index triangle) const {
    if (!active_) return Eigen::Vector3d::Zero();
    if (!patches_.empty()) return patches_[RelativeFlow::patch_of(surface_, triangle)];
    instrument::count(Effect::pillow);
    const Eigen::Vector3d normal = surface_.normal.row(triangle).matrix(), centroid = surface_.centroid.row(triangle).matrix();
    const Eigen::Vector3d ab = surface_.edge_ab.row(triangle).matrix(), ac = surface_.edge_ac.row(triangle).matrix();
    const Eigen::Vector3d u = flow_.at(centroid, triangle), a = centroid - (ab + ac) / 3.0;
    const double square_radius = (ab.squaredNorm() + ac.squaredNorm() - ab.dot(ac)) / 18.0;
    return directed(u, square_radius) * faded(u, normal, [&](double alpha) {
             return pillow_.form == PillowForm::eccentricity ? eccentricity_pillow_shift(a, a + ab, a + ac, u, alpha)
                                                             : triangle_pillow_shift(a, a + ab, a + ac, u, alpha, pillow_.falloff);
           });
  }

 private:
  /// Where the air turns about a face more than it passes it there is no leading edge: as BodyLaw does with what depends on one direction
  /// of flow.
  double directed(const Eigen::Vector3d& u, double square_radius) const {
    const double travel = u.squaredNorm(), variation = flow_.variation_per_metre();
    return travel > 0.0 ? travel / (travel + variation * variation * square_radius) : 0.0;
  }

  /// Under the note's factor, faded at normal incidence.
  template <class ShiftOf>
  Eigen::Vector3d faded(const Eigen::Vector3d& u, const Eigen::Vector3d& normal, ShiftOf shift_of) const {
    const double speed = u.norm();
    if (!(speed > 0.0)) return Eigen::Vector3d::Zero();
    return shift_of(faded_pillow_factor(pillow_.factor, std::abs(u.dot(normal)) / speed));
  }

  const Surface& surface_;
  const RelativeFlow& flow_;
  const Pillow& pillow_;
  bool active_;
  std::vector<Eigen::Vector3d> patches_;
};

/// The same as of the public header, seen from the side of the normal (1) or from the back of a sheet (-1), where what is convex is hollow.
double curvature_along(const Surface& surface, Eigen::Index triangle, const Eigen::Vector3d& tangential, double side);

/// Calls visit(LocalForce) for every contribution, triangle by triangle: the one place where the model walks over a surface.
/// @param every_point  of the model's rule, also where the flow is the same all over a triangle: what a change of spin would do needs them
template <class Visit>
void for_each_local_force(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model, Visit&& visit,
                          bool every_point = false) {
  using Eigen::Vector3d;
  const ActiveEffects active(motion, model);
  const RelativeFlow flow(surface, motion, active);
  const BodyLaw law(surface, model.law, flow, active);
  const PillowShift pillow(surface, flow, model.pillow, active);
  const bool leeward = law.feels_leeward();

  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Vector3d normal = surface.normal.row(i).matrix(), centroid = surface.centroid.row(i).matrix();
    const Vector3d ab = surface.edge_ab.row(i).matrix(), ac = surface.edge_ac.row(i).matrix();
    const Vector3d a = centroid - (ab + ac) / 3.0, shift = pillow.of(i);

    const auto at_point = [&](double s, double t, double weight) {
      const Vector3d r = a + s * ab + t * ac;
      const double half_rho_area = 0.5 * medium.density * surface.area[i] * weight;

      const auto feel = [&](const Vector3d& place, bool is_leeward) {
        const Vector3d u = flow.at(place, i);
        const double speed = u.norm(), w = -u.dot(normal);
        if (!(speed > 0.0) || w == 0.0) return;
        if (!surface.two_sided() && (w < 0.0) != is_leeward) return;
        const Vector3d outward =
            (w < 0.0) != is_leeward ? Vector3d(-normal) : normal;  // on a sheet one of the two sides is right for either
        const double c = std::min(1.0, std::abs(w) / speed);
        if (!(c > 0.0)) return;  // edge-on to the last bit
        const auto pass = [&](Term term, const Curve& coefficient) {
          visit(LocalForce{i, term, place - motion.reference_point, outward, u, speed, c, half_rho_area, coefficient});
        };
        if (is_leeward)
          law.leeward(c, pass);
        else
          law.windward(
              c, [&] { return curvature_along(surface, i, (u - normal * normal.dot(u)) / speed, w > 0.0 ? 1.0 : -1.0); }, pass);
      };
      feel(r + shift, false);
      if (leeward) feel(r, true);
      if (active.has<Effect::friction>()) {
        instrument::count(Effect::friction);
        const Vector3d u = flow.at(r, i);
        if (const double speed = u.norm(); speed > 0.0)
          visit(LocalForce{i,
                           Term::friction,
                           r - motion.reference_point,
                           normal,
                           u,
                           speed,
                           std::min(1.0, std::abs(u.dot(normal)) / speed),
                           half_rho_area * (surface.two_sided() ? 2.0 : 1.0),
                           {model.law.friction, 0.0}});
      }
    };
    const auto at_points = [&](Quadrature order, double share) {
      for (const QuadraturePoint& point : quadrature_rule(order)) at_point(point.s, point.t, share * point.weight);
    };

    if (!flow.varies_on_triangles() && !every_point) {
      at_points(Quadrature::one, 1.0);  // exact: the flow is the same all over the triangle
    } else if (model.quadrature != Quadrature::adaptive) {
      at_points(model.quadrature, 1.0);
    } else {
      const double radius =
          std::sqrt(std::max({(ab + ac).squaredNorm(), (2.0 * ab - ac).squaredNorm(), (2.0 * ac - ab).squaredNorm()})) / 3.0;
      const QuadratureShares shares = adaptive_shares(flow.variation_per_metre() * radius, flow.at(centroid, i).norm());
      if (shares.one > 0.0) at_points(Quadrature::one, shares.one);
      if (shares.three > 0.0) at_points(Quadrature::three, shares.three);
      if (shares.six > 0.0) at_points(Quadrature::six, shares.six);
    }
  }
}

/// A vector quantity summed over a surface, apart for what takes energy from the body's motion through the air and for what gives it.
/// The second is held below `largest_gain` of the first: eq. 13.
class EnergyBalance {
 public:
  void add(const LocalForce& local) {
    const double power = local.force().dot(local.u);
    (local.coefficient.value < 0.0 ? given_ : taken_) += std::abs(power);
  }
  bool has_gain() const { return given_ > 0.0; }
  /// Factor in [0, 1] on everything that gives: 1 - x^8/8 for little of it, never more than largest_gain * taken / given. Smooth.
  double gain_share() const {
    if (!(given_ > 0.0)) return 1.0;
    const double bound = largest_gain * taken_;
    const auto eighth = [](double x) { return x * x * x * x * x * x * x * x; };
    if (given_ <= bound) return std::pow(1.0 + eighth(given_ / bound), -0.125);
    return bound / given_ * std::pow(1.0 + eighth(bound / given_), -0.125);
  }

 private:
  double taken_ = 0.0, given_ = 0.0;
};

}  // namespace dragcore
