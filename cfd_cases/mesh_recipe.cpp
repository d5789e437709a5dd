#include "cfd_cases/mesh_recipe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

namespace cfd_cases {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// Distance from a point to an axis-aligned box.
double distance_to(const Vector3d& lower, const Vector3d& upper, const Vector3d& p) {
  return (lower - p).cwiseMax(p - upper).cwiseMax(0.0).norm();
}

double distance_to_box(const Vector3d& half_extent, const Vector3d& p) { return (p.cwiseAbs() - half_extent).cwiseMax(0.0).norm(); }

/// Distance in the meridian plane (x along the axis, r off it) to the region under a convex profile, whose points run from nose to tail.
double distance_to_profile(const std::vector<Vector2d>& profile, const Vector3d& p) {
  const Vector2d q(p.x(), std::hypot(p.y(), p.z()));
  double nearest = (q - profile.front()).norm();
  bool inside = true;
  for (std::size_t i = 1; i < profile.size(); ++i) {
    const Vector2d edge = profile[i] - profile[i - 1], to_q = q - profile[i - 1];
    nearest = std::min(nearest, (to_q - std::clamp(to_q.dot(edge) / edge.squaredNorm(), 0.0, 1.0) * edge).norm());
    if (edge.x() * to_q.y() - edge.y() * to_q.x() > 0.0) inside = false;  // left of an edge that runs downstream: in the air
  }
  return inside ? 0.0 : nearest;
}

struct Distance {
  Vector3d p;
  double nose;

  double operator()(const dragcore::Plate& s) const { return distance_to_box(0.5 * Vector3d(s.chord, s.span, s.thickness), p); }
  double operator()(const dragcore::Box& s) const { return distance_to_box(0.5 * Vector3d(s.length, s.width, s.height), p); }
  double operator()(const dragcore::Sphere& s) const { return std::max(0.0, p.norm() - 0.5 * s.diameter); }
  double operator()(const dragcore::Cone& s) const {
    const double r = 0.5 * s.diameter, tail = nose + r / std::tan(0.5 * s.apex_angle);
    return distance_to_profile({{nose, 0.0}, {tail, r}, {tail, 0.0}}, p);
  }
  double operator()(const dragcore::Cylinder& s) const {
    const double r = 0.5 * s.diameter;
    return distance_to_profile({{nose, 0.0}, {nose, r}, {-nose, r}, {-nose, 0.0}}, p);
  }
  double operator()(const dragcore::Ellipsoid& s) const {
    const Vector3d axes(s.semi_x, s.semi_y, s.semi_z);
    const double level = p.cwiseQuotient(axes).norm();  // 1 on the surface
    if (level <= 1.0) return 0.0;
    return (level - 1.0) * level / p.cwiseQuotient(axes.cwiseProduct(axes)).norm();
  }
  double operator()(const dragcore::Teardrop& s) const {
    const double r = 0.5 * s.diameter, centre = nose + r, tail = s.length - r;  // of the sphere; tail counted from there
    const Vector2d joint(centre + r * r / tail, r * std::sqrt(1.0 - r * r / (tail * tail)));
    const double to_sphere = (p - Vector3d(centre, 0.0, 0.0)).norm() - r;
    const double to_cone = distance_to_profile({{joint.x(), 0.0}, joint, {nose + s.length, 0.0}}, p);
    return std::max(0.0, std::min(to_sphere, to_cone));
  }
};

const std::map<std::string, double> kRefinement{{"coarse", 1.4}, {"medium", 1.0}, {"fine", 1.0 / 1.4}, {"finest", 1.0 / 1.96}};

/// The recipe's lengths and sizes by name, so that reading and writing cannot disagree.
template <class Recipe, class Visit>
void visit_fields(Recipe& r, Visit visit) {
  visit("body_size", r.body_size);
  visit("tip_size", r.tip_size);
  visit("growth", r.growth);
  visit("wake_size", r.wake_size);
  visit("wake_margin", r.wake_margin);
  visit("wake_length", r.wake_length);
  visit("outer_size", r.outer_size);
  visit("outer_margin", r.outer_margin);
  visit("outer_length", r.outer_length);
  visit("far_size", r.far_size);
  visit("upstream", r.upstream);
  visit("downstream", r.downstream);
  visit("sideways", r.sideways);
  visit("dual_feature_angle_deg", r.dual_feature_angle_deg);
  visit("refinement", r.refinement);
}

}  // namespace

std::string to_string(Symmetry symmetry) {
  return symmetry == Symmetry::none ? "none" : symmetry == Symmetry::plane_y ? "plane_y" : "plane_z";
}

Symmetry symmetry_from(const std::string& word) {
  for (const Symmetry symmetry : {Symmetry::none, Symmetry::plane_y, Symmetry::plane_z})
    if (word == to_string(symmetry)) return symmetry;
  throw std::invalid_argument(fmt::format("symmetry '{}' is unknown: use none, plane_y or plane_z", word));
}

Symmetry find_symmetry(const dragcore::Shape& shape, const dragcore::Pose& pose) {
  const Eigen::Matrix3d to_body = pose.rotation().transpose();
  if (dragcore::mirror_symmetric(shape, to_body * Vector3d::UnitY())) return Symmetry::plane_y;
  if (dragcore::mirror_symmetric(shape, to_body * Vector3d::UnitZ())) return Symmetry::plane_z;
  return Symmetry::none;
}

double body_scale(const dragcore::Shape& shape) {
  const Vector3d half = dragcore::properties(shape).half_extent;
  std::array<double, 3> extent{2.0 * half.x(), 2.0 * half.y(), 2.0 * half.z()};
  std::sort(extent.begin(), extent.end());
  return extent[1];
}

double refinement_of(const std::string& level) {
  if (const auto found = kRefinement.find(level); found != kRefinement.end()) return found->second;
  throw std::invalid_argument(fmt::format("mesh level '{}' is unknown: use coarse, medium, fine or finest", level));
}

double distance_to_body(const dragcore::Shape& shape, const Vector3d& point_body) {
  return std::visit(Distance{point_body, dragcore::properties(shape).nose_x}, shape);
}

double distance_to_tip(const dragcore::Shape& shape, const Vector3d& point_body) {
  const auto properties = dragcore::properties(shape);
  if (std::holds_alternative<dragcore::Cone>(shape)) return (point_body - Vector3d(properties.nose_x, 0, 0)).norm();
  if (std::holds_alternative<dragcore::Teardrop>(shape))
    return (point_body - Vector3d(properties.nose_x + properties.length_x, 0, 0)).norm();
  return std::numeric_limits<double>::infinity();
}

Eigen::AlignedBox3d air_around(const Eigen::AlignedBox3d& body, double scale, const MeshRecipe& recipe, Symmetry symmetry) {
  Vector3d inlet = body.min() - scale * Vector3d(recipe.upstream, recipe.sideways, recipe.sideways);
  const Vector3d outlet = body.max() + scale * Vector3d(recipe.downstream, recipe.sideways, recipe.sideways);
  if (symmetry == Symmetry::plane_y) inlet.y() = 0.0;
  if (symmetry == Symmetry::plane_z) inlet.z() = 0.0;
  return {inlet, outlet};
}

SizeField::SizeField(const dragcore::Shape& shape, const dragcore::Pose& pose, const MeshRecipe& recipe, const Eigen::AlignedBox3d& body)
    : shape_(shape), recipe_(recipe), body_(body), to_body_(pose.rotation().transpose()), scale_(body_scale(shape)) {}

double SizeField::operator()(const Vector3d& p) const {
  const auto boxed = [&](double margin, double length) {
    return distance_to(body_.min() - scale_ * Vector3d::Constant(margin), body_.max() + scale_ * Vector3d(length, margin, margin), p);
  };
  const double from_body = scale_ * recipe_.body_size + recipe_.growth * distance_to_body(shape_, to_body_ * p);
  const double from_wake = scale_ * recipe_.wake_size + recipe_.growth * boxed(recipe_.wake_margin, recipe_.wake_length);
  const double from_outer = scale_ * recipe_.outer_size + recipe_.growth * boxed(recipe_.outer_margin, recipe_.outer_length);
  const double from_tip = scale_ * recipe_.tip_size + recipe_.growth * distance_to_tip(shape_, to_body_ * p);
  return recipe_.refinement * std::min({from_body, from_tip, from_wake, from_outer, scale_ * recipe_.far_size});
}

nlohmann::json to_json(const MeshRecipe& recipe) {
  nlohmann::json text;
  visit_fields(recipe, [&](const char* name, double value) { text[name] = value; });
  return text;
}

MeshRecipe recipe_from_json(const nlohmann::json& text) {
  MeshRecipe recipe;
  visit_fields(recipe, [&](const char* name, double& value) { value = text.at(name).get<double>(); });
  return recipe;
}

nlohmann::json to_json(const dragcore::Shape& shape) {
  return {{"kind", dragcore::kind(shape)}, {"parameters", dragcore::parameters(shape)}};
}

dragcore::Shape shape_from_json(const nlohmann::json& text) {
  return dragcore::make_shape(text.at("kind").get<std::string>(), text.at("parameters").get<std::map<std::string, double>>());
}

}  // namespace cfd_cases
