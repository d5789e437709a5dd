#include "cfd_cases/mesh/mesh_recipe.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
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
  double operator()(const dragcore::Prism& s) const {
    const double half = 0.5 * s.base, tail = nose + half / std::tan(0.5 * s.apex_angle);
    const double to_triangle = distance_to_profile({{nose, 0.0}, {tail, half}, {tail, 0.0}}, Vector3d(p.x(), p.z(), 0.0));
    return std::hypot(to_triangle, std::max(0.0, std::abs(p.y()) - 0.5 * s.span));
  }
  double operator()(const dragcore::MeshBody& s) const {
    throw std::invalid_argument(fmt::format("the sizes around {}, which is given by triangles, are snappyHexMesh's", s.name));
  }
};

const std::map<std::string, double> kRefinement{{"coarse", 1.4}, {"medium", 1.0}, {"fine", 1.0 / 1.4}, {"finest", 1.0 / 1.96}};

const std::map<std::string, double> kOctreeRefinement{{"coarse", 2.0}, {"medium", 1.0}, {"fine", 0.5}, {"finest", 0.25}};

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
template <class Recipe, class Visit>
void visit_options(Recipe& r, Visit visit) {
  visit("far_radius", r.far_radius);
  visit("seed", r.seed);
  visit("hexahedra", r.hexahedra);
  visit("wake_rise", r.wake_rise);
  visit("first_layer", r.first_layer);
}

/// Where the wind turns towards, in a mesh that stays with the body: +z by incidence, -y by yaw.
Vector3d lee_side(Symmetry symmetry) { return symmetry == Symmetry::plane_z ? Vector3d(0, -1, 0) : Vector3d(0, 0, 1); }

}  // namespace

std::string to_string(Symmetry symmetry) {
  return symmetry == Symmetry::none ? "none" : symmetry == Symmetry::plane_y ? "plane_y" : "plane_z";
}

int halved_axis(Symmetry symmetry) { return symmetry == Symmetry::plane_y ? 1 : symmetry == Symmetry::plane_z ? 2 : -1; }

Symmetry symmetry_from(const std::string& word) {
  for (const Symmetry symmetry : {Symmetry::none, Symmetry::plane_y, Symmetry::plane_z})
    if (word == to_string(symmetry)) return symmetry;
  throw std::invalid_argument(fmt::format("symmetry '{}' is unknown: use none, plane_y or plane_z", word));
}

Symmetry find_symmetry(const dragcore::Shape& shape, const dragcore::Pose& pose, const Vector3d& spin_axis,
                       const Eigen::Matrix3d& to_wind) {
  const Eigen::Matrix3d to_body = pose.rotation().transpose();
  // The mirror image of a spin is the same spin only about the plane's own normal.
  const auto allows = [&](const Vector3d& normal_wind) {
    const Vector3d normal = to_body * normal_wind;
    return (to_wind * normal_wind - normal_wind).norm() < 1e-12 && dragcore::mirror_symmetric(shape, normal) &&
           spin_axis.cross(normal).norm() <= 1e-12 * spin_axis.norm();
  };
  if (allows(Vector3d::UnitY())) return Symmetry::plane_y;
  if (allows(Vector3d::UnitZ())) return Symmetry::plane_z;
  return Symmetry::none;
}

double body_scale(const dragcore::Shape& shape) {
  const Vector3d half = dragcore::properties(shape).half_extent;
  std::array<double, 3> extent{2.0 * half.x(), 2.0 * half.y(), 2.0 * half.z()};
  std::sort(extent.begin(), extent.end());
  return extent[1];
}

double kept_feature_angle_deg(const dragcore::Shape& shape, double asked) {
  const auto* prism = std::get_if<dragcore::Prism>(&shape);
  if (!prism) return asked;  // plates and boxes turn by 90 degrees, and the sides of all other bodies are round
  // At the point; the turn at the base, 90 degrees and half the angle of the point, is never below 90, nor that at the ends.
  const double turn = 180.0 - prism->apex_angle * 180.0 / std::numbers::pi;
  return turn > asked ? asked : 0.9 * turn;
}

double allowed_surface_error(const dragcore::Shape& shape, const MeshRecipe& recipe) {
  // Flat sides are exact but for the 12 digits of the file and OpenCASCADE's tolerance of 1e-7.
  if (std::holds_alternative<dragcore::Plate>(shape) || std::holds_alternative<dragcore::Box>(shape) ||
      std::holds_alternative<dragcore::Prism>(shape))
    return 1e-5;
  // Round sides: a facet of size h lies up to h^2 / 8R inside a circle of radius R = 1/2 scale, and the dual cuts its corners once more;
  // area and volume of a sphere then lose 0.4 and 0.6 (h/R)^2. Twice as much leaves room for the point of a cone, which the dual cuts off.
  // A flat ellipsoid is more curved for what it encloses, by about its surface over that of a ball of the same width, volume for volume.
  const double h = recipe.body_size * recipe.refinement / 0.5, allowed = 1.2 * h * h;
  if (!std::holds_alternative<dragcore::Ellipsoid>(shape)) return allowed;
  const auto whole = dragcore::properties(shape);
  return allowed * std::max(1.0, whole.area * 0.5 * body_scale(shape) / (3.0 * whole.volume));
}

MeshRecipe octree_recipe() {
  MeshRecipe recipe;
  recipe.hexahedra = 1.0;
  recipe.body_size = 0.025;
  recipe.wake_size = 0.05;
  recipe.wake_margin = 0.3;
  recipe.wake_length = 1.0;
  recipe.wake_rise = 0.5;
  recipe.outer_size = 0.1;
  recipe.outer_margin = 0.6;
  recipe.outer_length = 2.5;
  recipe.far_size = 1.6;
  recipe.upstream = recipe.sideways = 8.0;
  recipe.downstream = 14.4;
  return recipe;
}

MeshRecipe recipe_for(MeshRecipe recipe, const dragcore::Shape& shape, double reynolds) {
  if (recipe.first_layer != 0.0) return recipe;  // an O-grid follows the body as it is
  if (const auto* ellipsoid = std::get_if<dragcore::Ellipsoid>(&shape)) {
    const auto [shortest, longest] = std::minmax({ellipsoid->semi_x, ellipsoid->semi_y, ellipsoid->semi_z});
    recipe.body_size = std::min(recipe.body_size, 0.3 * shortest * shortest / longest / body_scale(shape));
  }
  if (reynolds >= 50.0 || recipe.hexahedra != 0.0 || recipe.far_radius != 0.0) return recipe;
  const MeshRecipe usual;
  for (const auto member : {&MeshRecipe::upstream, &MeshRecipe::downstream, &MeshRecipe::sideways})
    if (recipe.*member == usual.*member) recipe.*member = 30.0;
  if (recipe.far_size == usual.far_size) recipe.far_size = 6.0;
  return recipe;
}

MeshRecipe o_grid_recipe() {
  MeshRecipe recipe;
  recipe.first_layer = 0.0005;
  recipe.growth = 0.25;
  recipe.wake_size = 0.09;
  recipe.wake_length = 1.7;
  recipe.far_radius = 14.0;  // 8 before the body, 20 behind it
  return recipe;
}

double refinement_of(const std::string& level, bool octree) {
  const auto& known = octree ? kOctreeRefinement : kRefinement;
  if (const auto found = known.find(level); found != known.end()) return found->second;
  throw std::invalid_argument(fmt::format("mesh level '{}' is unknown: use coarse, medium, fine or finest", level));
}

OctreeSizes::OctreeSizes(const dragcore::Shape& shape, const MeshRecipe& recipe, Symmetry symmetry)
    : shape_(shape), recipe_(recipe), scale_(body_scale(shape)), half_(flat_half_extent(shape)) {
  lee_ = lee_side(symmetry);
  const double finest = recipe.body_size * recipe.refinement * scale_;
  for (const double half : half_)
    if (const double cells = half / finest; std::abs(cells - std::round(cells)) > 1e-6 || cells < 0.5)
      throw std::invalid_argument(fmt::format("half an edge of the {} is {} m, which is no multiple of the smallest cube, {} m",
                                              dragcore::kind(shape), half, finest));
}

bool OctreeSizes::too_large(const Vector3d& lower, const Vector3d& upper) const {
  // By the point of the cube nearest to each region, so that no layer of large cubes reaches into it.
  const auto distance = [&](double margin, double length, double rise) {
    const Vector3d below = -half_ - scale_ * (Vector3d::Constant(margin) - rise * lee_.cwiseMin(0.0));
    const Vector3d above =
        half_ + scale_ * (Vector3d::Constant(margin) + (length - margin) * Vector3d::UnitX() + rise * lee_.cwiseMax(0.0));
    return (lower - above).cwiseMax(below - upper).cwiseMax(0.0).norm();
  };
  // The smallest cubes fill a layer in which the shear layers of the edges roll up.
  constexpr double layer = 0.12;
  const double from_body = recipe_.body_size + recipe_.growth * distance(layer, layer, 0.0) / scale_;
  const double from_wake =
      recipe_.wake_size + recipe_.growth * distance(recipe_.wake_margin, recipe_.wake_length, recipe_.wake_rise) / scale_;
  const double from_outer =
      recipe_.outer_size + recipe_.growth * distance(recipe_.outer_margin, recipe_.outer_length, recipe_.wake_rise) / scale_;
  const double wanted = recipe_.refinement * scale_ * std::min({from_body, from_wake, from_outer, recipe_.far_size});
  // A cube that is up to 1.4 times too large stays: halves of it would be as much too small.
  return (upper - lower).maxCoeff() > std::max(1.4 * wanted, 1.01 * recipe_.body_size * recipe_.refinement * scale_);
}

BaseGrid base_grid(const dragcore::Shape& shape, const MeshRecipe& recipe, Symmetry symmetry) {
  const auto cubes = [&](double length) { return static_cast<int>(std::lround(length / recipe.far_size)); };
  BaseGrid grid{{cubes(recipe.upstream), cubes(recipe.sideways), cubes(recipe.sideways)},
                {cubes(recipe.downstream), cubes(recipe.sideways), cubes(recipe.sideways)},
                recipe.far_size * body_scale(shape)};
  const Vector3d lee = lee_side(symmetry);
  for (int axis = 0; axis < 3; ++axis) {
    if (lee[axis] > 0.0) grid.above[axis] = grid.above.x();
    if (lee[axis] < 0.0) grid.below[axis] = grid.above.x();
  }
  if (symmetry == Symmetry::plane_y) grid.below.y() = 0;
  if (symmetry == Symmetry::plane_z) grid.below.z() = 0;
  return grid;
}

Vector3d flat_half_extent(const dragcore::Shape& shape) {
  if (!std::holds_alternative<dragcore::Plate>(shape) && !std::holds_alternative<dragcore::Box>(shape))
    throw std::invalid_argument(fmt::format("an octree of cubes fits plates and boxes, not a {}", dragcore::kind(shape)));
  return dragcore::properties(shape).half_extent;
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
  Vector3d outlet = body.max() + scale * Vector3d(recipe.downstream, recipe.sideways, recipe.sideways);
  if (recipe.far_radius > 0.0) {
    outlet.setConstant(scale * recipe.far_radius);
    inlet = -outlet;
  }
  if (symmetry == Symmetry::plane_y) inlet.y() = 0.0;
  if (symmetry == Symmetry::plane_z) inlet.z() = 0.0;
  return {inlet, outlet};
}

SizeField::SizeField(const dragcore::Shape& shape, const dragcore::Pose& pose, const MeshRecipe& recipe, const Eigen::AlignedBox3d& body,
                     Symmetry symmetry)
    : shape_(shape),
      recipe_(recipe),
      body_(body),
      to_body_(pose.rotation().transpose()),
      lee_(lee_side(symmetry)),
      scale_(body_scale(shape)) {}

double SizeField::operator()(const Vector3d& p) const {
  const auto boxed = [&](double margin, double length) {
    return distance_to(body_.min() - scale_ * (Vector3d::Constant(margin) - recipe_.wake_rise * lee_.cwiseMin(0.0)),
                       body_.max() + scale_ * (Vector3d(length, margin, margin) + recipe_.wake_rise * lee_.cwiseMax(0.0)), p);
  };
  const double from_body = scale_ * recipe_.body_size + recipe_.growth * distance_to_body(shape_, to_body_ * p);
  const double from_wake = scale_ * recipe_.wake_size + recipe_.growth * boxed(recipe_.wake_margin, recipe_.wake_length);
  const double from_outer = scale_ * recipe_.outer_size + recipe_.growth * boxed(recipe_.outer_margin, recipe_.outer_length);
  const double from_tip = scale_ * recipe_.tip_size + recipe_.growth * distance_to_tip(shape_, to_body_ * p);
  return recipe_.refinement * std::min({from_body, from_tip, from_wake, from_outer, scale_ * recipe_.far_size});
}

std::vector<std::pair<const char*, double*>> recipe_lengths(MeshRecipe& recipe) {
  std::vector<std::pair<const char*, double*>> list;
  visit_fields(recipe, [&](const char* name, double& value) {
    if (std::string(name) != "refinement") list.emplace_back(name, &value);
  });
  list.emplace_back("far_radius", &recipe.far_radius);
  list.emplace_back("wake_rise", &recipe.wake_rise);
  list.emplace_back("first_layer", &recipe.first_layer);
  return list;
}

nlohmann::json to_json(const MeshRecipe& recipe) {
  nlohmann::json text;
  visit_fields(recipe, [&](const char* name, double value) { text[name] = value; });
  visit_options(recipe, [&](const char* name, double value) {
    if (value != 0.0) text[name] = value;
  });
  return text;
}

MeshRecipe recipe_from_json(const nlohmann::json& text) {
  MeshRecipe recipe;
  visit_fields(recipe, [&](const char* name, double& value) { value = text.at(name).get<double>(); });
  visit_options(recipe, [&](const char* name, double& value) { value = text.value(name, 0.0); });
  return recipe;
}

nlohmann::json to_json(const dragcore::Shape& shape) {
  nlohmann::json text{{"kind", dragcore::kind(shape)}, {"parameters", dragcore::parameters(shape)}};
  if (const auto* body = std::get_if<dragcore::MeshBody>(&shape)) text["triangles"] = fmt::format("{:016x}", body->checksum);
  return text;
}

dragcore::Shape shape_from_json(const nlohmann::json& text) {
  return dragcore::make_shape(text.at("kind").get<std::string>(), text.at("parameters").get<std::map<std::string, double>>());
}

}  // namespace cfd_cases
