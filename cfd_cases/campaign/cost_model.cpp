#include "cfd_cases/campaign/cost_model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "cfd_cases/mesh/cell_count.hpp"
#include "cfd_cases/mesh/o_grid.hpp"
#include "cfd_cases/mesh/snappy.hpp"

namespace cfd_cases {

namespace fs = std::filesystem;
using case_record::CaseRecord;

namespace {

/// Number of cells at which a power law has its value: the middle of the cases.
constexpr double kReferenceCells = 20000.0;

/// Stages whose cost is one of the mesh alone, whatever flows through it.
constexpr const char* kStages[] = {"mesh", "convert", "post"};

/// Relative standard deviation of the CPU time of one and the same case on a machine that others use too.
constexpr double kCaseNoise = 0.2;

// --- The file --------------------------------------------------------------------------------------------------------------------------

/// Numbers and tables of one table of the file, each read once; whatever is left over is unknown.
class Reader {
 public:
  Reader(const toml::table& table, std::string name, const fs::path& file) : table_(table), name_(std::move(name)), file_(file) {}

  [[noreturn]] static void fail(const fs::path& file, const toml::source_region& at, const std::string& message) {
    throw ConfigurationError(fmt::format("{}:{}:{}: {}", file.string(), at.begin.line, at.begin.column, message));
  }
  double number(const char* key, double lowest, double highest) {
    const toml::node& node = need(key, "a number");
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value || !(*value >= lowest && *value <= highest))
      fail(file_, node.source(), fmt::format("{} of [{}] is not usable: needed a number from {:g} to {:g}", key, name_, lowest, highest));
    return *value;
  }
  std::string text(const char* key) {
    const toml::node& node = need(key, "a text in quotes");
    if (!node.is_string()) fail(file_, node.source(), fmt::format("{} of [{}] must be a text in quotes", key, name_));
    return *node.value<std::string>();
  }
  Reader table(const std::string& key) {
    const toml::node& node = need(key, "a table");
    if (!node.is_table()) fail(file_, node.source(), fmt::format("{} must be a table", key));
    return {*node.as_table(), name_.empty() ? key : name_ + "." + key, file_};
  }
  std::vector<std::string> keys() const {
    std::vector<std::string> list;
    for (const auto& [key, node] : table_) list.emplace_back(key.str());
    return list;
  }
  void reject_unknown() const {
    for (const auto& [key, node] : table_)
      if (std::find(known_.begin(), known_.end(), key.str()) == known_.end())
        fail(file_, key.source(), fmt::format("unknown key '{}' in [{}]: known are {}", key.str(), name_, fmt::join(known_, ", ")));
  }

 private:
  const toml::node& need(const std::string& key, const char* what) {
    known_.push_back(key);
    if (const toml::node* node = table_.get(key)) return *node;
    fail(file_, table_.source(),
         fmt::format("{} is missing in [{}]: needed {}; `dragval cost --fit --write {}` makes the file anew", key, name_, what,
                     file_.string()));
  }

  const toml::table& table_;
  std::string name_;
  const fs::path& file_;
  std::vector<std::string> known_;
};

FitQuality read_quality(Reader& table) {
  return {static_cast<int>(table.number("cases", 0.0, 1e9)), table.number("rms", 0.0, 100.0), table.number("worst", 0.0, 100.0)};
}

PowerLaw read_law(Reader table, const char* value_key) {
  const PowerLaw law{table.number(value_key, 1e-12, 1e9), table.number("exponent", -1.0, 2.0), read_quality(table)};
  table.reject_unknown();
  return law;
}

std::string quality_text(const FitQuality& fit) {
  return fmt::format("cases = {}\nrms = {:.3f}\nworst = {:.3f}\n", fit.cases, fit.rms, fit.worst);
}

std::string law_text(const char* value_key, const PowerLaw& law) {
  return fmt::format("{} = {:.4g}\nexponent = {:.3f}\n", value_key, law.value, law.exponent) + quality_text(law.fit);
}

// --- The fit ---------------------------------------------------------------------------------------------------------------------------

/// Least squares of A x = b with Huber's weights: rows further off than 1.5 robust standard deviations count as if they were that far.
Eigen::VectorXd robust_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(b.size()), x;
  for (int pass = 0; pass < 30; ++pass) {  // converges to 1e-3 in about 10
    x = (weight.asDiagonal() * A).colPivHouseholderQr().solve(weight.cwiseProduct(b));
    const Eigen::VectorXd off = (b - A * x).cwiseAbs();
    std::vector<double> sorted(off.begin(), off.end());
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double sigma = 1.4826 * sorted[sorted.size() / 2] + 1e-12;
    weight = (off.array() / (1.5 * sigma)).max(1.0).sqrt().inverse();
  }
  return x;
}

/// @param off  ln(found / predicted)
FitQuality quality(const Eigen::ArrayXd& off) {
  return {static_cast<int>(off.size()), std::sqrt(off.square().mean()), off.abs().maxCoeff()};
}

PowerLaw fit_law(const std::vector<double>& cells, const std::vector<double>& found) {
  const auto n = static_cast<Eigen::Index>(cells.size());
  const Eigen::ArrayXd x = (Eigen::Map<const Eigen::ArrayXd>(cells.data(), n) / kReferenceCells).log();
  const Eigen::ArrayXd y = Eigen::Map<const Eigen::ArrayXd>(found.data(), n).log();
  // An exponent takes meshes of different size: at least a factor of 2 between them.
  const bool sloped = n >= 5 && x.maxCoeff() - x.minCoeff() > std::log(2.0);
  Eigen::MatrixXd A = Eigen::MatrixXd::Ones(n, sloped ? 2 : 1);
  if (sloped) A.col(1) = x;
  const Eigen::VectorXd solution = robust_solution(A, y);
  const Eigen::ArrayXd off = y - (A * solution).array();
  return {std::exp(solution[0]), sloped ? solution[1] : 0.0, quality(off)};
}

struct Sample {
  const CaseRecord* record;
  DescribedCase known;

  double cells() const { return record->cells; }
  double cpu_s(const std::string& stage) const {
    const auto found = record->cost.find(stage);
    return found == record->cost.end() ? 0.0 : found->second.cpu_s;
  }
  double total_cpu_s() const {
    double sum = 0.0;
    for (const auto& [stage, cost] : record->cost) sum += cost.cpu_s;
    return sum;
  }
};

/// Cases whose cost is that of a solution: others stopped early, or went through it twice.
bool ended_by_itself(const CaseRecord& record) {
  return (case_record::is_usable(record.status) || record.status == case_record::Status::drifting) && record.cells > 0 &&
         record.iterations > 0 && record.cost.contains("solve");
}

void fit_cells(CostModel& model, const std::vector<Sample>& all) {
  std::vector<Sample> samples;  // of cubes the number is counted, not fitted
  std::copy_if(all.begin(), all.end(), std::back_inserter(samples),
               [](const Sample& sample) { return !sample.known.spec.octree() && !sample.known.spec.o_grid(); });
  // Of the relative error: c = a V + b S divided by c.
  Eigen::MatrixXd A(static_cast<Eigen::Index>(samples.size()), 2);
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const Sample& sample = samples[static_cast<std::size_t>(i)];
    const CaseSpec& spec = sample.known.spec;
    const SizeIntegrals sum =
        integrate_size(spec.shape, spec.mesh_pose().radians(), sample.known.identity.recipe, sample.known.identity.symmetry);
    A.row(i) << sum.volume / sample.cells(), sum.surface / sample.cells();
  }
  const Eigen::VectorXd solution = robust_solution(A, Eigen::VectorXd::Ones(A.rows()));
  model.per_volume = solution[0];
  model.per_surface = solution[1];
  model.cells_fit = quality(-(A * solution).array().log());
}

void fit_method(CostModel& model, const std::string& flow_model, const std::vector<const Sample*>& samples) {
  std::vector<double> cells, speed, iterations;
  for (const Sample* sample : samples) {
    cells.push_back(sample->cells());
    speed.push_back(sample->cpu_s("solve") / sample->cells() / sample->record->iterations);
    iterations.push_back(sample->record->iterations);
  }
  CostModel::Method& method = model.methods[flow_model];
  method = {.solve = fit_law(cells, speed), .iterations = fit_law(cells, iterations), .total = {}};
  double work = 0.0, predicted_work = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    work += cells[i] * iterations[i];
    predicted_work += cells[i] * method.iterations(cells[i]);
  }
  method.iterations.value *= work / predicted_work;
  Eigen::ArrayXd off(static_cast<Eigen::Index>(samples.size()));
  std::transform(samples.begin(), samples.end(), off.begin(), [&](const Sample* sample) {
    return std::log(sample->total_cpu_s() / model.estimate(sample->known.spec, sample->known.identity).total_cpu_s());
  });
  method.total = quality(off);
}

}  // namespace

double CostEstimate::total_cpu_s() const {
  double sum = 0.0;
  for (const auto& [stage, seconds] : cpu_s) sum += seconds;
  return sum;
}

double PowerLaw::operator()(double cells) const { return value * std::pow(cells / kReferenceCells, exponent); }

const CostModel::Method& CostModel::method(const std::string& flow_model) const {
  if (const auto found = methods.find(flow_model); found != methods.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [word, unused] : methods) known.push_back(word);
  throw ConfigurationError(fmt::format("the cost model has no method '{}': add a table [method.{}] to {}; it has {}", flow_model,
                                       flow_model, cost_model_file().string(), fmt::join(known, ", ")));
}

double CostModel::solve_cpu_s(const std::string& flow_model, double cells, double iterations) const {
  return method(flow_model).solve(cells) * cells * iterations;
}

CostEstimate CostModel::estimate(const CaseSpec& spec, const CaseIdentity& identity) const {
  const Method& of = method(spec.flow_model);
  CostEstimate estimate;
  if (const auto* body = std::get_if<dragcore::MeshBody>(&spec.shape)) {
    estimate.cells = snappy_cells(*body, spec.mesh_pose().radians(), identity.recipe, identity.symmetry);
  } else if (spec.octree()) {
    estimate.cells = octree_cells(spec.shape, identity.recipe, identity.symmetry);
  } else if (spec.o_grid()) {
    estimate.cells = o_grid_cells(spec.shape, identity.recipe, identity.symmetry);
  } else {
    const SizeIntegrals sum = integrate_size(spec.shape, spec.mesh_pose().radians(), identity.recipe, identity.symmetry);
    estimate.cells = per_volume * sum.volume + per_surface * sum.surface;
  }
  estimate.relative_uncertainty = of.total.rms;
  const double least = std::min(spec.stop.min_iterations, spec.stop.max_iterations);
  estimate.iterations = spec.time_accurate() ? std::round(spec.time.duration / spec.time.step)
                                             : std::clamp<double>(of.iterations(estimate.cells), least, spec.stop.max_iterations);
  for (const char* stage : kStages) estimate.cpu_s[stage] = stages.at(stage)(estimate.cells) * estimate.cells;
  estimate.cpu_s["solve"] = solve_cpu_s(spec.flow_model, estimate.cells, estimate.iterations);
  estimate.memory_bytes = memory_bytes + memory_bytes_per_cell * estimate.cells;
  return estimate;
}

fs::path cost_model_file() {
  const fs::path installed = fs::path(CFD_CASES_SOURCE_DIR) / "campaign/cost_model.toml";
  return fs::exists(installed) ? installed : fs::path("cfd_cases/campaign/cost_model.toml");
}

CostModel parse_cost_model(std::string_view text, const fs::path& file) {
  toml::table root;
  try {
    root = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    Reader::fail(file, error.source(), std::string(error.description()));
  }
  CostModel model;
  Reader top(root, "", file);

  Reader provenance = top.table("provenance");
  for (const std::string& key : provenance.keys()) model.provenance[key] = provenance.text(key.c_str());

  Reader cells = top.table("cells");
  model.per_volume = cells.number("per_volume", 1e-3, 1e3);
  model.per_surface = cells.number("per_surface", 0.0, 1e3);
  model.cells_fit = read_quality(cells);
  cells.reject_unknown();

  Reader memory = top.table("memory");
  model.memory_bytes = memory.number("bytes", 0.0, 1e12);
  model.memory_bytes_per_cell = memory.number("bytes_per_cell", 0.0, 1e9);
  model.memory_measured = memory.text("measured");
  memory.reject_unknown();

  Reader stages = top.table("stage");
  for (const char* stage : kStages) model.stages[stage] = read_law(stages.table(stage), "cpu_s_per_cell");
  stages.reject_unknown();

  Reader methods = top.table("method");
  for (const std::string& word : methods.keys()) {
    Reader table = methods.table(word);
    CostModel::Method& method = model.methods[word];
    method.solve = read_law(table.table("solve"), "cpu_s_per_cell_iteration");
    method.iterations = read_law(table.table("iterations"), "iterations");
    Reader total = table.table("total");
    method.total = read_quality(total);
    total.reject_unknown();
    table.reject_unknown();
  }
  top.reject_unknown();
  return model;
}

CostModel read_cost_model(const fs::path& file) {
  std::ifstream in(file);
  if (!in) throw ConfigurationError(fmt::format("{}:0:0: no such file; needed the cost model of the repository", file.string()));
  std::ostringstream text;
  text << in.rdbuf();
  return parse_cost_model(text.str(), file);
}

std::string to_toml(const CostModel& model) {
  std::string text =
      "# What a CFD case costs, before it is solved; cost_model.hpp has the formulas. Values of laws are those at 20,000 cells, rms and\n"
      "# worst are of ln(found / predicted).\n\n[provenance]\n";
  for (const auto& [key, value] : model.provenance) text += fmt::format("{} = \"{}\"\n", key, value);
  text += fmt::format("\n[cells]  # per_volume int h^-3 dV + per_surface int h^-2 dA\nper_volume = {:.4g}\nper_surface = {:.4g}\n{}",
                      model.per_volume, model.per_surface, quality_text(model.cells_fit));
  for (const auto& [stage, law] : model.stages) text += fmt::format("\n[stage.{}]\n{}", stage, law_text("cpu_s_per_cell", law));
  for (const auto& [word, method] : model.methods) {
    text += fmt::format("\n[method.{}.solve]\n{}", word, law_text("cpu_s_per_cell_iteration", method.solve));
    text += fmt::format("\n[method.{}.iterations]\n{}", word, law_text("iterations", method.iterations));
    text += fmt::format("\n[method.{}.total]  # CPU time of whole cases\n{}", word, quality_text(method.total));
  }
  text += fmt::format(
      "\n[memory]  # of the largest program of a case; not fitted\nbytes = {:.3g}\nbytes_per_cell = {:.3g}\nmeasured = \"{}\"\n",
      model.memory_bytes, model.memory_bytes_per_cell, model.memory_measured);
  return text;
}

CostModel fit_cost_model(const CostModel& known, const std::vector<CaseRecord>& cases) {
  std::vector<Sample> samples;
  for (const CaseRecord& record : cases)
    if (auto described = described_case(record.description); described && ended_by_itself(record))
      samples.push_back({&record, std::move(*described)});
  if (samples.size() < 5)
    throw std::invalid_argument(fmt::format("{} of the {} cases were solved to their end by this program; 5 are needed to fit a cost model",
                                            samples.size(), cases.size()));

  CostModel model = known;
  fit_cells(model, samples);
  for (const char* stage : kStages) {
    std::vector<double> cells, cost;
    for (const Sample& sample : samples)
      if (sample.cpu_s(stage) > 0.0) {  // a drifting case has no post
        cells.push_back(sample.cells());
        cost.push_back(sample.cpu_s(stage) / sample.cells());
      }
    if (!cells.empty()) model.stages[stage] = fit_law(cells, cost);
  }
  std::map<std::string, std::vector<const Sample*>> by_method;
  for (const Sample& sample : samples) by_method[sample.known.spec.flow_model].push_back(&sample);
  for (const auto& [word, list] : by_method) fit_method(model, word, list);
  return model;
}

double Pace::relative_uncertainty() const { return kCaseNoise / std::sqrt(std::max(1, cases)); }

Pace pace_of(const CostModel& model, const std::vector<const CaseRecord*>& cases) {
  std::vector<double> ratios;
  for (const CaseRecord* record : cases)
    if (ended_by_itself(*record) && model.methods.contains(record->flow_model))
      ratios.push_back(record->cost.at("solve").cpu_s / model.solve_cpu_s(record->flow_model, record->cells, record->iterations));
  if (ratios.empty()) return {};
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return {.factor = *middle, .cases = static_cast<int>(ratios.size())};
}

}  // namespace cfd_cases
