#include <fmt/color.h>
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "compare/gate/gate.hpp"
#include "compare/tables/text_grid.hpp"

namespace compare {
namespace {

int failures(const GateResult& result) {
  return static_cast<int>(std::count_if(result.checks.begin(), result.checks.end(), [](const GateCheck& check) { return !check.passed; }));
}

std::string verdict(const GateResult& result) {
  const int failed = failures(result);
  return failed == 0 ? fmt::format("gate passed: {} checks, {} cases", result.checks.size(), result.compared)
                     : fmt::format("gate failed: {} of {} checks", failed, result.checks.size());
}

/// Each character of `from` by what stands for it.
std::string escaped(const std::string& text, const std::vector<std::pair<char, std::string>>& from) {
  std::string result;
  for (const char c : text) {
    const auto found = std::find_if(from.begin(), from.end(), [&](const auto& entry) { return entry.first == c; });
    result += found == from.end() ? std::string(1, c) : found->second;
  }
  return result;
}

std::string table(const GateResult& result, bool colour) {
  std::string text;
  for (const GateCheck& check : result.checks) {
    const std::string word = check.passed ? "pass" : "FAIL";
    const auto style = fg(check.passed ? fmt::terminal_color::green : fmt::terminal_color::red);
    text += fmt::format("{}  {:<45} {:>4}  {}\n", colour ? fmt::format(style, "{}", word) : word, check.name, check.compared, check.detail);
  }
  return text + verdict(result) + "\n";
}

/// What failed first and in full, what passed folded away: a pull request is read from the top.
std::string markdown_text(const GateResult& result) {
  TextGrid failed, passed;
  for (TextGrid* grid : {&failed, &passed}) grid->add({"check", "numbers", "detail"});
  for (const GateCheck& check : result.checks)
    (check.passed ? passed : failed).add({check.name, std::to_string(check.compared), escaped(check.detail, {{'|', "\\|"}})});
  std::string text = "**" + verdict(result) + "**\n\n";
  if (failed.rows.size() > 1) text += markdown(failed) + "\n";
  return text + fmt::format("<details><summary>{} checks passed</summary>\n\n{}\n</details>\n", passed.rows.size() - 1, markdown(passed));
}

std::string json_text(const GateResult& result) {
  nlohmann::json checks = nlohmann::json::array();
  for (const GateCheck& check : result.checks)
    checks.push_back({{"name", check.name}, {"passed", check.passed}, {"compared", check.compared}, {"detail", check.detail}});
  return nlohmann::json{{"passed", result.passed()}, {"planned", result.planned}, {"compared", result.compared}, {"checks", checks}}.dump(
             2) +
         "\n";
}

std::string junit(const GateResult& result) {
  const auto xml = [](const std::string& text) { return escaped(text, {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}}); };
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"dragval gate\" tests=\"{}\" failures=\"{}\" "
      "errors=\"0\">\n",
      result.checks.size(), failures(result));
  for (const GateCheck& check : result.checks) {
    text += fmt::format("<testcase classname=\"dragval.gate\" name=\"{}\"", xml(check.name));
    text += check.passed ? fmt::format("><system-out>{}</system-out></testcase>\n", xml(check.detail))
                         : fmt::format("><failure message=\"{}\"/></testcase>\n", xml(check.detail));
  }
  return text + "</testsuite>\n</testsuites>\n";
}

/// Workflow commands: https://docs.github.com/actions/reference/workflow-commands-for-github-actions
std::string github(const GateResult& result) {
  std::string text;
  for (const GateCheck& check : result.checks)
    if (!check.passed)
      text += fmt::format("::error title={}::{}\n", escaped(check.name, {{'%', "%25"}, {',', "%2C"}, {':', "%3A"}}),
                          escaped(check.detail, {{'%', "%25"}, {'\n', "%0A"}}));
  return text + (result.passed() ? "::notice title=gate::" : "::error title=gate::") + verdict(result) + "\n";
}

}  // namespace

GateFormat gate_format_from(const std::string& word) {
  const std::vector<std::pair<std::string, GateFormat>> known = {{"table", GateFormat::table},
                                                                 {"md", GateFormat::markdown},
                                                                 {"json", GateFormat::json},
                                                                 {"junit", GateFormat::junit},
                                                                 {"github", GateFormat::github}};
  for (const auto& [name, format] : known)
    if (name == word) return format;
  throw std::invalid_argument("--format " + word + " is unknown: use table, md, json, junit or github");
}

std::string render(const GateResult& result, GateFormat format, bool colour) {
  switch (format) {
    case GateFormat::markdown:
      return markdown_text(result);
    case GateFormat::json:
      return json_text(result);
    case GateFormat::junit:
      return junit(result);
    case GateFormat::github:
      return github(result);
    case GateFormat::table:
      break;
  }
  return table(result, colour);
}

}  // namespace compare
