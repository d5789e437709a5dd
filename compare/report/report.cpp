#include "compare/report/report.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "compare/report/packed.hpp"
#include "compare/report/report_bodies.hpp"
#include "compare/report/report_sections.hpp"

namespace compare {
namespace {

std::string content_of(const std::filesystem::path& path, const char* remedy) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(fmt::format("{} is missing; {}", path.string(), remedy));
  return {std::istreambuf_iterator<char>(file), {}};
}

void replace(std::string& page, const std::string& mark, const std::string& text) {
  const auto place = page.find(mark);
  if (place == std::string::npos) throw std::runtime_error("page.html of the report has no " + mark + "; restore it from the repository");
  page.replace(place, mark.size(), text);
}

/// With numbers to six digits, more than any figure shows.
std::string short_text(nlohmann::json value) {
  const auto round = [](auto& self, nlohmann::json& node) -> void {
    if (node.is_number_float())
      node = std::stod(fmt::format("{:.6g}", node.get<double>()));
    else if (node.is_structured())
      for (nlohmann::json& child : node) self(self, child);
  };
  round(round, value);
  return value.dump();
}

}  // namespace

std::string ReportedModel::label() const { return pillow == "none" ? law : law + ", " + choice.pillow_label(); }

Report make_report(Reference reference, std::vector<CaseRecord> spinning, const std::vector<std::string>& missing, bool quick_cost) {
  Report report{.reference = std::move(reference), .spinning = std::move(spinning)};
  const std::vector<CaseRecord>& cases = report.reference.cases;
  const auto add = [&](const ModelChoice& choice) {
    report.models.push_back(
        {law_label(choice.by_class ? "by class" : choice.model.law.name), to_string(choice.model.pillow.form), choice, {}});
    ReportedModel& added = report.models.back();
    added.table = compare_with(cases, predictor(choice), added.label(), missing);
  };
  for (const dragcore::Law& law : {dragcore::note_law(), dragcore::consistent_law()}) add(dragcore::Model{.law = law});
  add(ModelChoice::of_class());
  if (report.compared() == 0) return report;
  try {
    report.calibration = calibrate(cases);
  } catch (const std::invalid_argument& fault) {  // a smoke run has too few orientations: the page then says so
    report.calibration_fault = fault.what();
    return report;
  }
  for (const bool with_pillow : {false, true})
    for (const Fit& fit : report.calibration->fits)
      if ((fit.model.pillow.form != dragcore::PillowForm::none) == with_pillow) add(fit.model);
  add(ModelChoice::recommended());
  report.cost = measure_ladder(cases, {.calibration = &*report.calibration, .spinning = report.spinning, .quick = quick_cost});
  return report;
}

void write_report(const Report& report, const std::filesystem::path& output, const std::filesystem::path& assets,
                  const std::filesystem::path& wasm) {
  constexpr const char* restore = "call dragval from the root of the repository, or name the folder with --assets";
  constexpr const char* install = "fetch the figure libraries with scripts/run.sh or `npm ci --prefix compare/report`";
  std::string page = content_of(assets / "page.html", restore);
  std::string libraries;
  for (const char* file : {"vega/build/vega.min.js", "vega-lite/build/vega-lite.min.js", "vega-embed/build/vega-embed.min.js"})
    libraries += "<script>" + content_of(assets / "node_modules" / file, install) + "</script>\n";

  const std::vector<Sweep> list = sweeps(report);
  const auto specs = figures(report);
  nlohmann::json shown = specs;
  shown.erase("drag_against_orientation");  // repeats panels of the sweeps
  for (const char* file : {"three.core.min.js", "three.module.min.js"})
    libraries += packed(file, content_of(assets / "node_modules/three/build" / file, install));
  // Without Emscripten there is no library for pages: bodies.js then says how to get it.
  if (std::ifstream code{wasm, std::ios::binary}) libraries += packed("dragcore.mjs", {std::istreambuf_iterator<char>(code), {}});

  replace(page, "<!-- style -->", "<style>\n" + content_of(assets / "style.css", restore) + "</style>");
  replace(page, "<!-- sections -->", report_sections(report, list, specs, content_of(assets / "bodies.html", restore)));
  replace(page, "<!-- figures -->", packed("specifications", short_text(shown)) + packed("bodies", short_text(report_bodies(report))));
  replace(page, "<!-- libraries -->", libraries);
  replace(page, "<!-- show -->",
          "<script>\n" + content_of(assets / "show.js", restore) + "</script>\n<script type=\"module\">\n" +
              content_of(assets / "bodies.js", restore) + "</script>");

  if (output.has_parent_path()) std::filesystem::create_directories(output.parent_path());
  std::ofstream file(output, std::ios::binary);
  file << page;
  file.flush();
  if (!file)
    throw std::runtime_error(fmt::format("cannot write {}; check that the folder is writable and the disk not full", output.string()));
}

}  // namespace compare
