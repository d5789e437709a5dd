#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/calibration/prediction.hpp"
#include "compare/reference/case_of_record.hpp"
#include "compare/reference/coefficients.hpp"
#include "compare/reference/published.hpp"
#include "compare/reference/uncertainty.hpp"

namespace compare {

enum class Verdict { resolved, within_noise };  ///< |error| > 2u, or not

/// One case and one channel: model against reference.
struct ErrorRow {
  std::string case_name;
  std::string family;  ///< shape, Re and flow_class(): "plate span=2, Re 100, laminar"
  std::string shape;   ///< kind, with the parameters that differ from make_shape()'s defaults: "plate span=2"
  double incidence_deg = 0.0;
  double yaw_deg = 0.0;
  double roll_deg = 0.0;
  double reynolds = 0.0;
  std::string flow_model;
  std::string flow_class;  ///< flow_class(): of an experiment, of which solutions it takes the place
  std::string mesh_level;
  bool held_out = false;
  std::string status;  ///< to_string(Status), or "missing"
  std::string reason;  ///< why there is no comparison
  Channel channel = Channel::drag;
  std::optional<double> model;  ///< coefficient; x_cp may be undefined on either side
  std::optional<double> cfd;
  double u = 0.0;                        ///< standard uncertainty of `cfd`
  double u_numerical = 0.0;              ///< the same without the part of the method
  std::optional<double> other_branch;    ///< `cfd` on the other branch, where stepping the angle up and down ends in two flows
  bool discretisation_assessed = false;  ///< false: `u` lacks the part of the mesh and is printed with a *
  std::optional<double> error;           ///< model - cfd
  std::optional<double> relative_error;  ///< error / |cfd|; empty where |cfd| < 2u or < 5 % of the largest of its family and channel
  std::optional<Verdict> verdict;
  std::optional<PublishedValue> published;  ///< on the reference area of docs/conventions.md
  std::string doubts;                       ///< why the laws by class may be wrong here (dragcore::Validity): "low Reynolds number; smooth body"
};

/// How often doubts are raised where they should be, and where not: cases by the relative error of the force vector.
struct DoubtCount {
  int large = 0, doubted_large = 0;  ///< beyond 25 %
  int small = 0, doubted_small = 0;  ///< below 10 %
};

/// Errors of a group of rows of one channel. Bias with the 95 % interval of Student's t; worst: largest |error|.
struct ErrorSummary {
  std::string group;
  Channel channel = Channel::drag;
  int n = 0;
  double bias = 0.0;
  std::optional<double> bias_half_width;  ///< of the interval; empty for n = 1
  double rms = 0.0;
  double worst = 0.0;
  std::string worst_case;
  std::optional<double> rms_relative;  ///< over rows that have a relative error
  int resolved = 0;                    ///< rows whose error is more than the noise of the reference
  /// Bias factor and relative scatter of the model as the FDS Validation Guide defines them (log-normal, noise of the reference taken off);
  /// for C_D with two or more rows.
  std::optional<double> bias_factor;
  std::optional<double> scatter;
};

struct ErrorTable {
  std::string model_name;
  std::vector<ErrorRow> rows;
  std::vector<ErrorSummary> totals;  ///< of all shown rows: turbulent ones fitted to, turbulent ones held out, laminar ones; by channel
  std::vector<ErrorSummary> summaries;
  std::vector<PublishedCheck> published;  ///< the CFD chain against published values
  std::vector<std::string> notes;         ///< how u_disc was found, case by case, and which of several families stands for a pose
  DoubtCount doubts;
  int compared = 0;                       ///< cases with both sides
};

/// What summaries group by, in any combination; empty means shape and Re.
enum class GroupBy { shape, orientation, reynolds, held_out };
GroupBy group_by_from(const std::string& word);  ///< @throws std::invalid_argument with the known words

/// Which cases a table shows, by their names; empty for all.
using CaseFilter = std::function<bool(const std::string& case_name)>;

/// Compares a model with the case of record of each pose, at its finest usable mesh.
/// Channels: C_D; for poses by incidence C_L and C_m, for those by yaw C_S and C_n, for combined ones all four, and for a pose at zero
/// those of the sweeps of its family; x_cp where it is defined and known to a length: further off it says nothing.
/// @param missing  names of planned cases without a record: they become rows with status "missing"
/// @param shown    the other cases still count for uncertainties, channels and relative errors, so that a row is the same in every choice
ErrorTable compare_with(const std::vector<case_record::CaseRecord>& records, const Predictor& model, const std::string& model_name,
                        const std::vector<std::string>& missing = {}, const std::vector<GroupBy>& by = {}, const CaseFilter& shown = {});

/// The statistics of rows that carry an error, all of one channel.
ErrorSummary summarise(const std::string& group, const std::vector<const ErrorRow*>& rows);

enum class Format { table, markdown, csv, json };
Format format_from(const std::string& word);  ///< "table", "md", "csv", "json"; @throws std::invalid_argument

/// @param colour  ANSI colour in Format::table
std::string render(const ErrorTable& table, Format format, bool colour = false);

/// Both sides of every row with errors, uncertainty and units, HDF5 (docs/results.md).
void write_comparison(const std::filesystem::path& path, const std::vector<ErrorTable>& tables);

/// "low Reynolds number; smooth body"; empty where nothing is doubted.
std::string doubts_of(const dragcore::Validity& validity);

/// "plate span=2": kind of shape, with the parameters that differ from the defaults.
std::string shape_label(const dragcore::Shape& shape);

/// Everything in the table, as Format::json writes it.
nlohmann::json to_json(const ErrorTable& table);

}  // namespace compare
