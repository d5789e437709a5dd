#include "compare/tables/explanation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <sstream>
#include <stdexcept>

#include "compare/tables/error_table.hpp"
#include "compare/tables/text_grid.hpp"

namespace compare {
namespace {

using case_record::CaseRecord;
using Eigen::Vector3d;
constexpr double degrees = 180.0 / std::numbers::pi;

std::string pose_text(const CaseRecord& record) {
  std::string text;
  for (const auto& [name, angle] : {std::pair("yaw ", record.pose.yaw), std::pair("roll ", record.pose.roll)})
    if (angle != 0.0) text += fmt::format(", {}{:g}°", name, std::round(1e4 * angle * degrees) / 1e4);
  if (record.pose.incidence != 0.0 || text.empty())
    text = fmt::format(", incidence {:g}°", std::round(1e4 * record.pose.incidence * degrees) / 1e4) + text;
  return text.substr(2);
}

/// A body by its whole label where there is one of that name, else by a part of it: "plate" is not "crossed_plates".
bool is_body(const CaseRecord& record, const std::string& body, bool whole) {
  const std::string label = shape_label(record.shape);
  return whole ? label == body : label.find(body) != std::string::npos;
}

bool asked(const CaseRecord& record, const PoseQuestion& question, bool whole) {
  constexpr double same_angle = 0.05;  // [deg]: names of poses have at most four digits
  if (record.spins() || record.still_air || std::abs(record.reynolds / question.reynolds - 1.0) > 1e-6) return false;
  if (!is_body(record, question.body, whole)) return false;
  const auto at = [&](const std::optional<double>& wanted, double angle) {
    return !wanted || std::abs(*wanted - angle * degrees) < same_angle;
  };
  return at(question.incidence_deg, record.pose.incidence) && at(question.yaw_deg, record.pose.yaw);
}

/// What the pressures of the model add to C_D, patch by patch of the stored reference; and those of the reference. Closed bodies cannot
/// tell one gauge of pressure from another: the one that brings the two nearest together is taken.
std::optional<Explanation::Patch> worst_patch(const CaseRecord& record, const std::vector<PatchMean>& patches, const NamedModel& named) {
  if (patches.empty() || record.reynolds < 1e4) return std::nullopt;  // below, a share of the viscous terms is pressure
  const dragcore::Surface& surface = prepared_surface(record.shape, default_divisions(record.shape));
  dragcore::Model model = named.choice.on(surface);
  model.effects = model.effects.without(dragcore::Effect::friction | dragcore::Effect::viscous);
  const dragcore::TriangleForces forces = dragcore::triangle_forces(surface, motion_of(record), medium_of(record), model);
  const Vector3d along = record.pose.rotation().transpose() * Vector3d::UnitX();
  const double q = 0.5 * record.density * record.speed * record.speed, area = dragcore::properties(record.shape).reference_area;
  std::map<std::string, Vector3d> sums;
  for (Eigen::Index i = 0; i < surface.size(); ++i)
    sums.try_emplace(patch_of(record.shape, surface.centroid.row(i).matrix().transpose(), surface.normal.row(i).matrix().transpose()),
                     Vector3d::Zero())
        .first->second += forces.force.col(i);
  // A patch that none of the model's triangles belongs to feels nothing.
  const auto force_on = [&](const PatchMean& patch) -> Vector3d {
    const auto found = sums.find(patch.name);
    return found == sums.end() ? Vector3d::Zero() : Vector3d(found->second / q);
  };
  double products = 0.0, squares = 0.0;
  for (const PatchMean& patch : patches) {
    const Vector3d gap = force_on(patch) - patch.pressure_force;
    products += gap.dot(patch.area_vector), squares += patch.area_vector.squaredNorm();
  }
  const double gauge = squares > 0.0 ? products / squares : 0.0;
  std::optional<Explanation::Patch> worst;
  for (const PatchMean& patch : patches) {
    const Explanation::Patch here{patch.name, along.dot(force_on(patch) - gauge * patch.area_vector) / area,
                                  along.dot(patch.pressure_force) / area};
    if (!worst || std::abs(here.model - here.reference) > std::abs(worst->model - worst->reference)) worst = here;
  }
  return worst;
}

double drag_of(const CaseRecord& record, const dragcore::Wrench& wrench) {
  return coefficients(record, wrench.force, wrench.torque).values[0];
}

Explanation explain(const CaseOfRecord& chosen, const std::vector<PatchMean>& patches, const NamedModel& named,
                    const std::vector<NamedModel>& others) {
  const CaseFamily& family = chosen.family;
  const CaseRecord& record = *family.record;
  Explanation result;
  result.title = fmt::format("{}, {}, Re {:g}", shape_label(record.shape), pose_text(record), record.reynolds);
  result.case_name = record.name;
  result.model_name = named.name;
  result.method = record.is_experiment() ? "measured, " + record.source
                                         : fmt::format("{}, {}, {} cells", record.flow_model, record.mesh_level, record.cells);
  const dragcore::WrenchByTerm wrench = predict(record, named.choice);
  const auto scales = coefficient_scales(record);
  result.model = drag_of(record, wrench.total());
  result.reference = coefficients(record).values[0];
  result.u = family.uncertainty.total[0] / scales[0];
  result.discretisation_assessed = family.uncertainty.discretisation_assessed;
  result.force_error = (wrench.total().force - record.load.force()).norm() / record.load.force().norm();
  const auto predicted = coefficients(record, wrench.total().force, wrench.total().torque).values;
  const Coefficients stored = coefficients(record);
  for (int k = 1; k < 6; ++k) {
    const double error = predicted[k] - stored.values[k], u = family.uncertainty.total[k] / scales[k];
    if (stored.known[static_cast<std::size_t>(k)] && std::abs(error) > std::max(2.0 * u, 0.01))
      result.also.push_back({symbol(static_cast<Channel>(k)), error, u});
  }
  result.doubts = doubts_of(validity(record));
  for (std::size_t k = 0; k < wrench.terms.size(); ++k)
    if (const double drag = wrench.terms[k].force.x() / scales[0]; std::abs(drag) > 0.01 * std::abs(result.model))
      result.terms.emplace_back(to_string(static_cast<dragcore::Term>(k)), drag);
  std::sort(result.terms.begin(), result.terms.end(), [](const auto& a, const auto& b) { return std::abs(a.second) > std::abs(b.second); });
  result.worst_patch = worst_patch(record, patches, named);
  for (const NamedModel& other : others) {
    if (other.name == named.name) continue;
    const double error = drag_of(record, predict(record, other.choice).total()) / result.reference - 1.0;
    if (!result.law || std::abs(error) < std::abs(result.law->error)) result.law = {other.name, error, std::nullopt};
  }
  const double half = 0.5 * std::abs(result.error() / result.reference);
  for (const CaseRecord* level : family.usable_levels()) {
    if (level->is_experiment()) continue;
    const double error = coefficients(*level).values[0] / result.reference - 1.0;
    double cpu_s = 0.0;
    for (const auto& [stage, cost] : level->cost) cpu_s += cost.cpu_s;
    if (std::abs(error) <= half && (!result.cfd || cpu_s < *result.cfd->cpu_s))
      result.cfd = {fmt::format("OpenFOAM's {} mesh", level->mesh_level), error, cpu_s};
  }
  return result;
}

}  // namespace

PoseQuestion pose_question(const std::string& body, const std::string& pose, double reynolds) {
  PoseQuestion question{.body = body, .incidence_deg = {}, .yaw_deg = {}, .reynolds = reynolds};
  if (!(reynolds > 0.0 && std::isfinite(reynolds)))
    throw std::invalid_argument(fmt::format("--re {}: a Reynolds number above 0 is needed", reynolds));
  std::string words = pose;
  std::replace(words.begin(), words.end(), '=', ' ');
  std::istringstream stream(words);
  const auto refuse = [&] {
    throw std::invalid_argument(fmt::format("pose '{}': degrees are needed, such as 30, 'yaw 45' or 'incidence 20 yaw 15'", pose));
  };
  std::string word;
  while (stream >> word) {
    std::optional<double>& angle = word == "yaw" ? question.yaw_deg : question.incidence_deg;
    if ((word == "yaw" || word == "incidence") && !(stream >> word)) refuse();
    char* end = nullptr;
    angle = std::strtod(word.c_str(), &end);
    if (end != word.c_str() + word.size() || !std::isfinite(*angle)) refuse();
  }
  if (!question.incidence_deg && !question.yaw_deg) refuse();
  if (!question.yaw_deg) question.yaw_deg = 0.0;
  if (!question.incidence_deg) question.incidence_deg = 0.0;
  return question;
}

std::vector<Explanation> explain_error(const Reference& reference, const NamedModel& model, const std::vector<NamedModel>& others,
                                       const PoseQuestion& question) {
  std::vector<Explanation> found;
  std::set<std::string> bodies, poses;
  const bool whole = std::any_of(reference.cases.begin(), reference.cases.end(),
                                 [&](const CaseRecord& record) { return is_body(record, question.body, true); });
  for (const CaseOfRecord& chosen : cases_of_record(reference.cases)) {
    const CaseRecord& record = *chosen.family.record;
    if (!case_record::is_usable(record.status) || record.spins()) continue;
    bodies.insert(shape_label(record.shape));
    if (is_body(record, question.body, whole))
      poses.insert(fmt::format("{}, {}, Re {:g}", shape_label(record.shape), pose_text(record), record.reynolds));
    if (!asked(record, question, whole)) continue;
    const auto at = static_cast<std::size_t>(&record - reference.cases.data());
    found.push_back(explain(chosen, at < reference.patches.size() ? reference.patches[at] : std::vector<PatchMean>{}, model, others));
  }
  if (found.empty() && poses.empty())
    throw std::invalid_argument(fmt::format("no body '{}' among the references: {}", question.body, fmt::join(bodies, ", ")));
  if (found.empty()) throw std::invalid_argument(fmt::format("that pose is not stored; there are\n  {}", fmt::join(poses, "\n  ")));
  return found;
}

std::string render(const Explanation& e) {
  const auto percent = [](double share) { return fmt::format("{:+.1f} %", 100.0 * share); };
  std::string text = fmt::format("{}: C_D\n", e.title);
  text += fmt::format("  model:      {:.3f} by '{}'{}\n", e.model, e.model_name, e.doubts.empty() ? "" : "; it doubts itself: " + e.doubts);
  text += fmt::format("  reference:  {:.3f} ± {:.3f} ({}; one standard uncertainty{})\n", e.reference, e.u, e.method,
                      e.discretisation_assessed ? "" : ", the mesh's part not known");
  text += fmt::format("  error:      of C_D {:+.3f} ({}), {:.1f} u: {}; the force vector is off by {:.1f} %", e.error(),
                      percent(e.error() / e.reference), std::abs(e.error()) / std::max(e.u, 1e-12),
                      e.resolved() ? "real" : "within the reference's own noise", 100.0 * e.force_error);
  for (const Explanation::Channel& channel : e.also)
    text += fmt::format("; real, too, is that of {}: {:+.3f} ({:.1f} u)", channel.symbol, channel.error,
                        std::abs(channel.error) / std::max(channel.u, 1e-12));
  text += "\n";
  std::vector<std::string> terms;
  for (const auto& [name, drag] : e.terms) terms.push_back(fmt::format("{} {:.3f}", name, drag));
  text += fmt::format("  made of:    {}", fmt::join(terms, ", "));
  if (e.worst_patch)
    text += fmt::format("; furthest off is patch {}: pressure there adds {:.3f}, in OpenFOAM {:.3f}", e.worst_patch->name,
                        e.worst_patch->model, e.worst_patch->reference);
  text += "\n  half of it: ";
  const double half = 0.5 * std::abs(e.error() / e.reference);
  if (!e.resolved()) text += "of C_D, not to be told from the noise: a better reference comes first";
  if (e.resolved() && e.law && std::abs(e.law->error) <= half)
    text += fmt::format("'{}' is {} off in this pose, at no more cost (dragval compare --law ... says what it is elsewhere); ", e.law->name,
                        percent(e.law->error));
  else if (e.resolved())
    text += "no law has it here; ";
  if (e.resolved() && e.cfd && e.cfd->error == 0.0)
    text += fmt::format("the reference itself took {:.0f} CPU s", *e.cfd->cpu_s);
  else if (e.resolved() && e.cfd)
    text += fmt::format("{}, {} off the reference, took {:.0f} CPU s", e.cfd->name, percent(e.cfd->error), *e.cfd->cpu_s);
  else if (e.resolved())
    text += "no CFD that is stored has it";
  return text + "\n";
}

nlohmann::json to_json(const Explanation& e) {
  nlohmann::json document = {{"title", e.title},
                             {"case", e.case_name},
                             {"model_name", e.model_name},
                             {"method", e.method},
                             {"model", e.model},
                             {"reference", e.reference},
                             {"u", e.u},
                             {"discretisation_assessed", e.discretisation_assessed},
                             {"error", e.error()},
                             {"resolved", e.resolved()},
                             {"force_error", e.force_error},
                             {"also_resolved", nlohmann::json::array()},
                             {"doubts", e.doubts},
                             {"terms", nlohmann::json::object()},
                             {"patch", nullptr},
                             {"nearest_law", nullptr},
                             {"cfd_with_half_the_error", nullptr}};
  for (const Explanation::Channel& channel : e.also)
    document["also_resolved"].push_back({{"channel", channel.symbol}, {"error", channel.error}, {"u", channel.u}});
  for (const auto& [name, drag] : e.terms) document["terms"][name] = drag;
  if (e.worst_patch)
    document["patch"] = {{"name", e.worst_patch->name}, {"model", e.worst_patch->model}, {"reference", e.worst_patch->reference}};
  if (e.law) document["nearest_law"] = {{"name", e.law->name}, {"relative_error", e.law->error}};
  if (e.cfd)
    document["cfd_with_half_the_error"] = {{"name", e.cfd->name}, {"relative_error", e.cfd->error}, {"cpu_s", optional_json(e.cfd->cpu_s)}};
  return document;
}

}  // namespace compare
