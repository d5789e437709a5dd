#include "compare/reference/published.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "compare/reference/read_selector.hpp"

extern const char* const published_toml;  // published.toml, compiled in (CMakeLists.txt)

namespace compare {

using case_record::CaseRecord;

namespace {

using Eigen::Vector3d;
constexpr double deg = std::numbers::pi / 180.0;

PublishedEntry entry_from(const toml::table& table) {
  constexpr double half_degree = 0.5;
  PublishedEntry entry;
  entry.cases.incidence_deg = entry.cases.yaw_deg = {-half_degree, half_degree};  // head on, unless it says more
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    const auto text = [&] { return node.value<std::string>().value(); };
    const auto number = [&] { return node.value<double>().value(); };
    if (read_selector(entry.cases, name, node)) continue;
    if (name == "quantity")
      entry.quantity = text();
    else if (name == "value")
      entry.published.value = number();
    else if (name == "uncertainty")
      entry.published.uncertainty = number();
    else if (name == "citation")
      entry.published.citation = text();
    else if (name == "kind")
      entry.published.kind = text();
    else if (name == "confidence")
      entry.published.confidence = text();
    else if (name == "conversion")
      entry.published.conversion = text();
    else if (name == "area_factor")
      entry.area_factor = number();
    else if (name == "reynolds_power")
      entry.reynolds_power = number();
    else if (name == "reynolds_squared")
      entry.reynolds_squared = number();
    else if (name == "goal")
      entry.goal = number();
    else if (name == "note_label")
      entry.note_label = text();
    else
      throw std::invalid_argument(fmt::format("published.toml, line {}: unknown key '{}'", key.source().begin.line, name));
  }
  return entry;
}

double measured(const CaseRecord& record, const std::string& quantity, const Vector3d& force, const Vector3d& moment) {
  const Coefficients c = coefficients(record, force, moment);
  if (quantity == "C_D") return *c[Channel::drag];
  if (quantity == "C_L") return *c[Channel::lift];
  if (quantity == "C_m") return *c[Channel::pitch];
  if (quantity == "force_angle_deg") return std::atan2(*c[Channel::drag], *c[Channel::lift]) / deg;
  if (quantity == "C_spin") return c.values.tail<3>().dot(record.angular_velocity.normalized());
  throw std::invalid_argument("published.toml: nothing measures the quantity '" + quantity + "'");
}

}  // namespace

bool PublishedEntry::fits(const CaseRecord& record) const {
  if (quantity == "C_spin" ? !record.spins() || !record.still_air : record.spins()) return false;
  return cases.fits(record);
}

PublishedValue PublishedEntry::on_reference_area(const CaseRecord& record) const {
  PublishedValue converted = published;
  // A force normal to the plate has the direction of its incidence: the one value that depends on the case.
  if (quantity == "force_angle_deg") converted.value = record.pose.incidence / deg;
  const double factor =
      area_factor * std::pow(record.reynolds, reynolds_power) * (1.0 + reynolds_squared * record.reynolds * record.reynolds);
  converted.value *= factor;
  converted.uncertainty *= std::abs(factor);
  return converted;
}

const std::vector<PublishedEntry>& published_entries() {
  static const std::vector<PublishedEntry> entries = [] {
    std::vector<PublishedEntry> list;
    const toml::table file = toml::parse(std::string_view(published_toml), std::string_view("published.toml"));
    for (const toml::node& node : *file["value"].as_array()) list.push_back(entry_from(*node.as_table()));
    return list;
  }();
  return entries;
}

std::optional<PublishedValue> published_value(const CaseRecord& record, const std::string& quantity) {
  for (const PublishedEntry& entry : published_entries())
    if (entry.quantity == quantity && entry.fits(record)) return entry.on_reference_area(record);
  return std::nullopt;
}

namespace {

using Quantity = std::function<double(const CaseRecord&, const Vector3d& force, const Vector3d& moment)>;

/// The errors of a mesh in lift and drag go together, and cancel in the angle: an angle has the mesh error of its own values over the
/// levels.
double numerical_uncertainty(const CaseFamily& family, const Quantity& quantity, bool is_angle) {
  const CaseRecord& record = *family.record;
  LoadUncertainty::Channels u = family.uncertainty.numerical;
  const auto levels = family.usable_levels();
  double mesh = 0.0;
  if (is_angle && levels.size() >= 2) try {
      std::vector<double> cells, values;
      for (const CaseRecord* level : levels)
        cells.push_back(level->cells), values.push_back(quantity(*level, level->load.force(), level->load.moment()));
      mesh = mesh_study(cells, values, record.flow_model).uncertainty;
      u = (u.cwiseAbs2() - family.uncertainty.discretisation.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
    } catch (const std::invalid_argument&) {  // refused meshes: the forces have what is carried
    }
  return std::hypot(mesh,
                    propagated(record, u, [&](const Vector3d& f, const Vector3d& m) { return std::optional(quantity(record, f, m)); }));
}

void add_checks(std::vector<PublishedCheck>& checks, const CaseFamily& family, bool of_record) {
  const CaseRecord& record = *family.record;
  if (!case_record::is_usable(record.status) || record.is_experiment()) return;  // it is a published value itself
  const Vector3d force = record.load.force(), moment = record.load.moment();
  const LoadUncertainty& u = family.uncertainty;
  for (const PublishedEntry& entry : published_entries()) {
    if (!entry.fits(record)) continue;
    const Quantity quantity = [&](const CaseRecord& level, const Vector3d& f, const Vector3d& m) {
      return measured(level, entry.quantity, f, m);
    };
    PublishedCheck check{.case_name = record.name, .flow_model = record.flow_model, .of_record = of_record, .quantity = entry.quantity};
    check.cfd = quantity(record, force, moment);
    check.u = numerical_uncertainty(family, quantity, check.is_angle());
    // The method's part scales the whole load: an angle has none of it.
    if (force.norm() > 0.0 && !check.is_angle()) check.u_method = std::abs(check.cfd) * u.method.head<3>().norm() / force.norm();
    check.discretisation_assessed = u.discretisation_assessed;
    check.published = entry.on_reference_area(record);
    check.goal = entry.goal;
    checks.push_back(std::move(check));
  }
}

}  // namespace

std::vector<PublishedCheck> published_checks(const std::vector<CaseRecord>& records, bool alternatives) {
  return published_checks(cases_of_record(records), alternatives);
}

std::vector<PublishedCheck> published_checks(const std::vector<CaseOfRecord>& cases, bool alternatives) {
  std::vector<PublishedCheck> checks;
  for (const CaseOfRecord& chosen : cases) {
    add_checks(checks, chosen.family, true);
    if (!alternatives && !chosen.family.record->is_experiment()) continue;
    for (const CaseFamily& alternative : chosen.alternatives) add_checks(checks, alternative, false);
  }
  return checks;
}

}  // namespace compare
