#include "compare/calibration/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <dragcore/expose.hpp>
#include <map>
#include <mutex>
#include <string>
#include <tuple>

namespace compare {

int default_divisions(const dragcore::Shape& shape) {
  return std::holds_alternative<dragcore::Plate>(shape) || std::holds_alternative<dragcore::Box>(shape) ? 2 : 32;
}

dragcore::Surface surface_of(const dragcore::Shape& shape, int divisions) {
  using Sides = dragcore::Surface::Sides;
  const auto* plate = std::get_if<dragcore::Plate>(&shape);
  // As a user's file: lids on its holes, and rays to find what stands in the lee of what.
  if (const auto* body = std::get_if<dragcore::MeshBody>(&shape))
    return dragcore::Surface(dragcore::expose(dragcore::prepare(*body->mesh)));
  const bool sheet = plate && plate->thickness == 0.0;
  return dragcore::Surface(dragcore::triangulate(shape, divisions), sheet ? Sides::two : Sides::one);
}

const dragcore::Surface& prepared_surface(const dragcore::Shape& shape, int divisions) {
  static std::mutex mutex;
  static std::map<std::tuple<std::string, std::map<std::string, double>, int>, dragcore::Surface> surfaces;
  const std::scoped_lock lock(mutex);
  std::string body = dragcore::kind(shape);
  if (const auto* mesh = std::get_if<dragcore::MeshBody>(&shape)) {
    body += ' ' + std::to_string(mesh->checksum);
    divisions = 0;  // it keeps its triangles
  }
  const auto key = std::tuple(body, dragcore::parameters(shape), divisions);
  const auto found = surfaces.find(key);
  if (found != surfaces.end()) return found->second;
  return surfaces.emplace(key, surface_of(shape, divisions)).first->second;
}

ModelChoice ModelChoice::of_class(const dragcore::Pillow& pillow) {
  ModelChoice choice(dragcore::Model{.pillow = pillow});
  choice.by_class = true;
  return choice;
}

ModelChoice ModelChoice::recommended() {
  ModelChoice choice = of_class(dragcore::class_pillow(dragcore::BodyClass::sharp));
  choice.pillow_by_class = true;
  return choice;
}

std::string ModelChoice::pillow_label() const {
  if (model.pillow.form == dragcore::PillowForm::none) return "";
  const std::string form = to_string(model.pillow.form) + " pillow ";
  return form + (pillow_by_class ? "by class" : fmt::format("{:g}", model.pillow.factor)) +
         (model.pillow.falloff == dragcore::Falloff::circular ? "" : " " + to_string(model.pillow.falloff));
}

dragcore::Model ModelChoice::on(const dragcore::Surface& surface) const {
  if (!by_class) return model;
  dragcore::Model chosen = dragcore::model_for(surface);
  chosen.precision = model.precision;  // double unless asked for: tables are of the model's error, not of rounding
  chosen.quadrature = model.quadrature;
  chosen.effects = model.effects;
  if (pillow_by_class) return chosen;
  chosen.pillow = model.pillow;
  if (chosen.sheets) chosen.sheets->pillow = model.pillow;
  return chosen;
}

dragcore::Motion motion_of(const case_record::CaseRecord& record) {
  const Eigen::Matrix3d to_body = record.pose.rotation().transpose();
  dragcore::Motion motion;
  if (!record.still_air) motion.wind = to_body * Eigen::Vector3d(record.speed, 0.0, 0.0);
  motion.angular_velocity = to_body * record.angular_velocity;
  return motion;
}

dragcore::Medium medium_of(const case_record::CaseRecord& record) {
  return {.density = record.density, .viscosity = record.density * record.viscosity};
}

dragcore::Validity validity(const case_record::CaseRecord& record) {
  // Class, extents and size of a round body are the same on few triangles, and found in a fraction of the time.
  const dragcore::Surface& surface = prepared_surface(record.shape, std::min(8, default_divisions(record.shape)));
  return dragcore::validity(surface, motion_of(record), medium_of(record), dragcore::model_for(surface));
}

dragcore::WrenchByTerm predict(const case_record::CaseRecord& record, const ModelChoice& choice, int divisions) {
  const dragcore::Surface& surface = prepared_surface(record.shape, divisions > 0 ? divisions : default_divisions(record.shape));
  const Eigen::Matrix3d to_wind = record.pose.rotation();
  dragcore::WrenchByTerm wrench = dragcore::wrench(surface, motion_of(record), medium_of(record), choice.on(surface));
  for (dragcore::Wrench& term : wrench.terms) term = {to_wind * term.force, to_wind * term.torque};
  return wrench;
}

Predictor predictor(const ModelChoice& choice, int divisions) {
  return [choice, divisions](const case_record::CaseRecord& record) { return predict(record, choice, divisions).total(); };
}

}  // namespace compare
