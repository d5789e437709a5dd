#include "compare/tables/error_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>
#include <tuple>

#include "compare/store/hdf5.hpp"

namespace compare {
namespace {

using case_record::CaseRecord;
using Eigen::Vector3d;

constexpr double deg = std::numbers::pi / 180.0;
// A relative error says nothing where the reference is near zero: against the largest value of its group, or against its own noise.
constexpr double near_zero = 0.05;
constexpr double largest_arm_uncertainty = 1.0;  // of x_cp, in lengths of the body: a point that may as well lie beyond it is not known
constexpr double rounding_residue = 1e-9;        // coefficients that are zero but for rounding, u included

/// Which lateral force and moment a pose drives. A combined pose drives both; one at zero is compared in the channels of its family's
/// sweeps, from which a combined pose takes nothing and to which it adds nothing.
struct Driven {
  bool incidence = false, yaw = false;

  static Driven by(const dragcore::Pose& pose) {
    const bool combined = pose.roll != 0.0 && (pose.incidence != 0.0 || pose.yaw != 0.0);
    return {pose.incidence != 0.0 || combined, pose.yaw != 0.0 || combined};
  }
  bool both() const { return incidence && yaw; }
  bool none() const { return !incidence && !yaw; }

  std::vector<Channel> channels() const {
    std::vector<Channel> list = {Channel::drag};
    if (incidence || !yaw) list.insert(list.end(), {Channel::lift, Channel::pitch});
    if (yaw) list.insert(list.end(), {Channel::side, Channel::yaw});
    list.push_back(Channel::centre_of_pressure);
    return list;
  }
};

/// Standard uncertainty of the CFD's coefficients, with the part of the method or without. A force that is wrong by some per cent has the
/// same line of action: x_cp has no part of the method.
double channel_uncertainty(const CaseRecord& record, const LoadUncertainty& u, Channel channel, bool with_method) {
  const auto index = static_cast<Eigen::Index>(channel);
  if (channel != Channel::centre_of_pressure) return (with_method ? u.total : u.numerical)[index] / coefficient_scales(record)[index];
  return propagated(record, u.numerical,
                    [&](const Vector3d& force, const Vector3d& moment) { return coefficients(record, force, moment).centre_of_pressure; });
}

ErrorRow row_of(const CaseRecord& record) {
  ErrorRow row;
  row.case_name = record.name;
  row.shape = shape_label(record.shape);
  row.flow_class = flow_class(record);
  row.family = fmt::format("{}, Re {:g}, {}", row.shape, record.reynolds, row.flow_class);
  row.incidence_deg = record.pose.incidence / deg;
  row.yaw_deg = record.pose.yaw / deg;
  row.roll_deg = record.pose.roll / deg;
  row.reynolds = record.reynolds;
  row.flow_model = record.flow_model;
  row.mesh_level = record.mesh_level;
  row.held_out = record.held_out;
  row.status = case_record::to_string(record.status);
  row.reason = record.reason;
  return row;
}

/// How u_disc was found.
std::string mesh_note(const CaseFamily& family) {
  const LoadUncertainty& u = family.uncertainty;
  if (family.record->is_experiment()) return fmt::format("{}: an experiment, {}", family.record->name, family.record->source);
  if (!u.discretisation_assessed) return fmt::format("{}: u of the mesh {}", family.record->name, u.branches.front());
  return fmt::format("{}: u of the mesh in C_D {:.2g} from {} usable level{}, {}", family.record->name,
                     u.discretisation[0] / coefficient_scales(*family.record)[0], family.usable_levels().size(),
                     family.usable_levels().size() == 1 ? "" : "s", u.branches.front());
}

std::string group_label(const ErrorRow& row, const std::vector<GroupBy>& by) {
  if (by.empty()) return row.family;
  std::string label;
  for (const GroupBy part : by) {
    if (!label.empty()) label += ", ";
    if (part == GroupBy::shape) label += row.shape;
    if (part == GroupBy::held_out) label += row.held_out ? "held out" : "fitted to";
    if (part == GroupBy::reynolds) label += fmt::format("Re {:g}, {}", row.reynolds, row.flow_model);
    if (part == GroupBy::orientation)
      label += fmt::format("incidence {:.4g}, yaw {:.4g}, roll {:.4g}", row.incidence_deg, row.yaw_deg, row.roll_deg);
  }
  return label;
}

/// Relative errors need the size of their group first.
void add_relative_errors(std::vector<ErrorRow>& rows) {
  std::map<std::pair<std::string, Channel>, double> scale;
  for (const ErrorRow& row : rows)
    if (row.cfd) scale[{row.family, row.channel}] = std::max(scale[{row.family, row.channel}], std::abs(*row.cfd));
  for (ErrorRow& row : rows)
    if (row.error && std::abs(*row.cfd) >= std::max({near_zero * scale[{row.family, row.channel}], 2.0 * row.u, rounding_residue}))
      row.relative_error = *row.error / std::abs(*row.cfd);
}

std::vector<ErrorSummary> summaries_of(const std::vector<ErrorRow>& rows, const std::vector<GroupBy>& by) {
  std::map<std::pair<std::string, Channel>, std::vector<const ErrorRow*>> groups;
  for (const ErrorRow& row : rows)
    if (row.error) groups[{group_label(row, by), row.channel}].push_back(&row);
  std::vector<ErrorSummary> summaries;
  for (const auto& [group, members] : groups) summaries.push_back(summarise(group.first, members));
  return summaries;
}

/// The whole table in a few numbers.
std::vector<ErrorSummary> totals_of(const std::vector<ErrorRow>& rows) {
  const std::array<std::pair<const char*, std::function<bool(const ErrorRow&)>>, 3> groups = {
      {{"turbulent", [](const ErrorRow& row) { return row.flow_class != "laminar" && !row.held_out; }},
       {"turbulent, held out", [](const ErrorRow& row) { return row.flow_class != "laminar" && row.held_out; }},
       {"laminar", [](const ErrorRow& row) { return row.flow_class == "laminar"; }}}};
  std::vector<ErrorSummary> totals;
  for (const auto& [name, belongs] : groups)
    for (const Channel channel : all_channels) {
      std::vector<const ErrorRow*> members;
      for (const ErrorRow& row : rows)
        if (row.channel == channel && row.error && belongs(row)) members.push_back(&row);
      if (!members.empty()) totals.push_back(summarise(name, members));
    }
  return totals;
}

}  // namespace

std::string doubts_of(const dragcore::Validity& valid) {
  std::string words;
  for (unsigned bit = 1; bit <= valid.doubts; bit <<= 1)
    if (valid.doubts & bit) words += (words.empty() ? "" : "; ") + to_string(static_cast<dragcore::Doubt>(bit));
  return words;
}

std::string shape_label(const dragcore::Shape& shape) {
  std::string label = dragcore::kind(shape);
  for (const auto& [name, value] : dragcore::changed_parameters(shape)) label += fmt::format(" {}={:g}", name, value);
  return label;
}

GroupBy group_by_from(const std::string& word) {
  if (word == "shape") return GroupBy::shape;
  if (word == "orientation") return GroupBy::orientation;
  if (word == "Re" || word == "reynolds") return GroupBy::reynolds;
  if (word == "held_out") return GroupBy::held_out;
  throw std::invalid_argument("cannot group by '" + word + "'; known: shape, orientation, Re, held_out");
}

ErrorSummary summarise(const std::string& group, const std::vector<const ErrorRow*>& rows) {
  ErrorSummary summary;
  summary.group = group;
  double squares = 0.0, relative_squares = 0.0;
  int relative = 0;
  std::vector<double> logs;  // of model / reference
  double noise_squares = 0.0;
  for (const ErrorRow* row : rows) {
    if (!row->error) throw std::invalid_argument("a row of " + row->case_name + " has no error; statistics take compared rows only");
    summary.channel = row->channel;
    ++summary.n;
    summary.bias += *row->error;
    squares += *row->error * *row->error;
    if (summary.n == 1 || std::abs(*row->error) > std::abs(summary.worst)) summary.worst = *row->error, summary.worst_case = row->case_name;
    if (row->relative_error) relative_squares += *row->relative_error * *row->relative_error, ++relative;
    if (row->verdict == Verdict::resolved) ++summary.resolved;
    if (row->channel == Channel::drag && *row->model > 0.0 && *row->cfd > 0.0) {
      logs.push_back(std::log(*row->model / *row->cfd));
      noise_squares += std::pow(row->u / *row->cfd, 2);
    }
  }
  if (summary.n == 0) return summary;
  const double n = summary.n;
  summary.bias /= n;
  summary.rms = std::sqrt(squares / n);
  if (relative > 0) summary.rms_relative = std::sqrt(relative_squares / relative);
  if (summary.n > 1) {
    const double variance = std::max(0.0, (squares - n * summary.bias * summary.bias) / (n - 1.0));
    // In double: valgrind, which has no long double, can then count what the program does.
    using Double = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
    const double t = boost::math::quantile(boost::math::students_t_distribution<double, Double>(n - 1.0), 0.975);
    summary.bias_half_width = t * std::sqrt(variance / n);
  }
  if (logs.size() > 1) {
    // Log-normal model error: its scatter is what remains of the scatter of ln(M/E) once the noise of the reference is taken off, and the
    // mean of the logarithms becomes the mean ratio by half the difference of the variances. [fds_validation]
    const double count = static_cast<double>(logs.size());
    double mean = 0.0, variance = 0.0;
    for (const double value : logs) mean += value / count;
    for (const double value : logs) variance += (value - mean) * (value - mean) / (count - 1.0);
    const double noise = noise_squares / count;
    const double model = std::max(0.0, variance - noise);
    summary.bias_factor = std::exp(mean + 0.5 * (model - noise));
    summary.scatter = std::sqrt(model);
  }
  return summary;
}

namespace {

}  // namespace

ErrorTable compare_with(const std::vector<CaseRecord>& records, const Predictor& model, const std::string& model_name,
                        const std::vector<std::string>& missing, const std::vector<GroupBy>& by, const CaseFilter& shown) {
  const auto is_shown = [&](const std::string& case_name) { return !shown || shown(case_name); };
  ErrorTable table;
  table.model_name = model_name;
  const std::vector<CaseOfRecord> cases = cases_of_record(records);
  std::map<std::string, Driven> driven;
  for (const CaseOfRecord& chosen : cases) {
    const CaseRecord& record = *chosen.family.record;
    const Driven own = Driven::by(record.pose);
    Driven& axes = driven[row_of(record).family];
    if (own.both()) continue;
    axes.incidence |= own.incidence;
    axes.yaw |= own.yaw;
  }

  for (const CaseOfRecord& chosen : cases) {
    const CaseFamily& family = chosen.family;
    const CaseRecord& record = *family.record;
    const bool usable = case_record::is_usable(record.status);
    ErrorRow row = row_of(record);
    row.held_out = chosen.held_out;
    const dragcore::Wrench predicted = model(record);
    const Coefficients ours = coefficients(record, predicted.force, predicted.torque);
    const Coefficients theirs = coefficients(record);
    const dragcore::Validity valid = validity(record);
    row.doubts = doubts_of(valid);
    if (usable && record.knows_force() && is_shown(record.name)) {
      const Eigen::Vector3d found = theirs.values.head<3>();
      const double relative = (ours.values.head<3>() - found).norm() / found.norm();
      table.doubts.large += relative > 0.25;
      table.doubts.doubted_large += relative > 0.25 && !valid.in_range();
      table.doubts.small += relative < 0.1;
      table.doubts.doubted_small += relative < 0.1 && !valid.in_range();
    }
    row.discretisation_assessed = family.uncertainty.discretisation_assessed;
    const std::optional<Coefficients> other =
        chosen.other_branch ? std::optional(coefficients(*chosen.alternatives[*chosen.other_branch].record)) : std::nullopt;
    const Driven own = Driven::by(record.pose);
    for (const Channel channel : (own.none() ? driven.at(row.family) : own).channels()) {
      row.channel = channel;
      row.model = ours[channel];
      row.cfd = usable ? theirs[channel] : std::nullopt;
      row.reason = usable && !row.cfd && channel != Channel::centre_of_pressure ? "not measured" : record.reason;
      row.u = row.cfd ? channel_uncertainty(record, family.uncertainty, channel, true) : 0.0;
      if (channel == Channel::centre_of_pressure && row.u > largest_arm_uncertainty) {
        row.reason = fmt::format("not known: its u is {:.2g} lengths of the body", row.u);
        row.cfd.reset();
        row.u = 0.0;
      }
      row.u_numerical = row.cfd ? channel_uncertainty(record, family.uncertainty, channel, false) : 0.0;
      row.other_branch = other ? (*other)[channel] : std::nullopt;
      row.error = row.model && row.cfd ? std::optional(*row.model - *row.cfd) : std::nullopt;
      row.verdict.reset();
      if (row.error)
        row.verdict = std::abs(*row.error) > std::max(2.0 * row.u, rounding_residue) ? Verdict::resolved : Verdict::within_noise;
      if (!record.is_experiment()) row.published = published_value(record, symbol(channel));
      // Where neither side has a centre of pressure there is nothing to tell.
      if (channel == Channel::centre_of_pressure && !row.model && !row.cfd) continue;
      table.rows.push_back(row);
    }
    if (!is_shown(record.name)) continue;
    if (usable) ++table.compared;
    if (usable) table.notes.push_back(mesh_note(family));
    if (!chosen.note.empty()) table.notes.push_back(chosen.note);
  }
  std::stable_sort(table.rows.begin(), table.rows.end(), [](const ErrorRow& a, const ErrorRow& b) {
    return std::tie(a.family, a.roll_deg, a.incidence_deg, a.yaw_deg) < std::tie(b.family, b.roll_deg, b.incidence_deg, b.yaw_deg);
  });
  add_relative_errors(table.rows);
  std::erase_if(table.rows, [&](const ErrorRow& row) { return !is_shown(row.case_name); });
  table.totals = totals_of(table.rows);
  table.summaries = summaries_of(table.rows, by);
  table.published = published_checks(cases);
  std::erase_if(table.published, [&](const PublishedCheck& check) { return !is_shown(check.case_name); });
  for (const std::string& name : missing) {
    if (!is_shown(name)) continue;
    ErrorRow row;
    row.case_name = name;
    row.family = row.shape = "no result";
    row.status = "missing";
    row.reason = "planned, but nothing is stored: dragval run";
    table.rows.push_back(row);
  }
  return table;
}

void write_comparison(const std::filesystem::path& path, const std::vector<ErrorTable>& tables) {
  const std::scoped_lock lock(hdf5::library_mutex());
  hdf5::write_file(path, "dragval comparison", "1.1", [&](const hdf5::Handle& file) {
    hdf5::write_attribute(file, "conventions", "docs/conventions.md; NaN: not defined for this row, its status says why");
    for (const ErrorTable& table : tables) {
      if (table.rows.empty()) throw std::invalid_argument("the comparison with " + table.model_name + " has no rows; nothing to store");
      const hdf5::Handle group = hdf5::create_group(file, table.model_name);
      const auto words = [&](const char* name, const char* long_name, auto value) {
        std::vector<std::string> list;
        for (const ErrorRow& row : table.rows) list.push_back(value(row));
        hdf5::write(group, name, list, {"none", long_name, "", ""});
      };
      const auto numbers = [&](const char* name, const hdf5::Meaning& meaning, auto value) {
        hdf5::Table column(static_cast<Eigen::Index>(table.rows.size()), 1);
        for (std::size_t i = 0; i < table.rows.size(); ++i) {
          const std::optional<double> number = value(table.rows[i]);
          column(static_cast<Eigen::Index>(i)) = number.value_or(std::numeric_limits<double>::quiet_NaN());
        }
        hdf5::write(group, name, column, meaning);
      };
      words("case", "case, named by the matrix", [](const ErrorRow& row) { return row.case_name; });
      words("channel", "coefficient; x_cp is the centre of pressure in lengths from the nose",
            [](const ErrorRow& row) { return symbol(row.channel); });
      words("family", "shape, Re and flow model", [](const ErrorRow& row) { return row.family; });
      words("status", "how the CFD case ended, or missing", [](const ErrorRow& row) { return row.status; });
      words("verdict", "resolved: |error| > 2u; noise: not", [](const ErrorRow& row) {
        return std::string(!row.verdict ? "" : *row.verdict == Verdict::resolved ? "resolved" : "noise");
      });
      numbers("incidence", {"deg", "incidence", "", ""}, [](const ErrorRow& row) { return row.incidence_deg; });
      numbers("yaw", {"deg", "yaw", "", ""}, [](const ErrorRow& row) { return row.yaw_deg; });
      numbers("roll", {"deg", "roll", "", ""}, [](const ErrorRow& row) { return row.roll_deg; });
      numbers("reynolds", {"1", "Reynolds number", "", ""}, [](const ErrorRow& row) { return row.reynolds; });
      numbers("model", {"1", "coefficient of the drag model", "wind", ""}, [](const ErrorRow& row) { return row.model; });
      numbers("cfd", {"1", "coefficient of the reference", "wind", "u"}, [](const ErrorRow& row) { return row.cfd; });
      numbers("u", {"1", "standard uncertainty of cfd", "", ""}, [](const ErrorRow& row) { return row.u; });
      numbers("u_numerical", {"1", "the part of u that is not of the method", "", ""}, [](const ErrorRow& row) { return row.u_numerical; });
      numbers("other_branch", {"1", "coefficient on the other branch of the flow", "wind", ""},
              [](const ErrorRow& row) { return row.other_branch; });
      numbers("discretisation_assessed", {"1", "1: u holds the part of the mesh", "", ""},
              [](const ErrorRow& row) { return row.discretisation_assessed ? 1.0 : 0.0; });
      numbers("error", {"1", "model - cfd", "", "u"}, [](const ErrorRow& row) { return row.error; });
      numbers("relative_error", {"1", "error / |cfd|", "", ""}, [](const ErrorRow& row) { return row.relative_error; });
      numbers("published", {"1", "published value on the same reference area", "wind", ""},
              [](const ErrorRow& row) { return row.published ? std::optional(row.published->value) : std::nullopt; });
    }
  });
}

}  // namespace compare
