#include "compare/reference/method_uncertainty.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "compare/reference/read_selector.hpp"

extern const char* const method_uncertainty_toml;  // method_uncertainty.toml, compiled in (CMakeLists.txt)

namespace compare {

const std::vector<MethodUncertainty>& method_uncertainties() {
  static const std::vector<MethodUncertainty> entries = [] {
    std::vector<MethodUncertainty> list;
    const toml::table file = toml::parse(std::string_view(method_uncertainty_toml), std::string_view("method_uncertainty.toml"));
    for (const toml::node& node : *file["method"].as_array()) {
      MethodUncertainty& entry = list.emplace_back();
      for (const auto& [key, value] : *node.as_table()) {
        const std::string name(key.str());
        if (name == "relative")
          entry.relative = value.value<double>().value();
        else if (name == "holds_mesh")
          entry.holds_mesh = value.value<bool>().value();
        else if (name == "reason")
          entry.reason = value.value<std::string>().value();
        else if (name == "evidence")
          entry.evidence = value.value<std::string>().value();
        else if (!read_selector(entry.cases, name, value))
          throw std::invalid_argument(fmt::format("method_uncertainty.toml, line {}: unknown key '{}'", key.source().begin.line, name));
      }
    }
    return list;
  }();
  return entries;
}

const MethodUncertainty* method_uncertainty(const case_record::CaseRecord& record) {
  if (record.spins()) return nullptr;  // every entry was found on bodies at rest
  const auto& entries = method_uncertainties();
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const MethodUncertainty& entry) { return entry.cases.fits(record); });
  return found == entries.end() ? nullptr : &*found;
}

}  // namespace compare
