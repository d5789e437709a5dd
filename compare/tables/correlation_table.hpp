#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/tables/error_table.hpp"

namespace compare {

/// One case of record: C_D on A_ref, of the reference, the law and each of peers::correlations(), in their order.
struct CorrelationRow {
  std::string case_name;
  double reynolds = 0.0;
  double reference = 0.0, u = 0.0;
  double law = 0.0;
  std::vector<std::optional<double>> correlations;  ///< empty where it says nothing of the body
};

/// C_D of a correlation for a case, on A_ref; empty where it says nothing of the body. @param index  into peers::correlations()
std::optional<double> correlated_drag(const case_record::CaseRecord& record, std::size_t index);

/// Usable cases of record at rest in a wind whose drag is known, up to Re 1e4 (above it is the realm of the laws without Re), by Re and
/// name.
std::vector<CorrelationRow> correlation_table(const std::vector<case_record::CaseRecord>& records, const Predictor& law);

/// With the mean of |error / reference| by Re under it, each over the rows where there is a value.
std::string render(const std::vector<CorrelationRow>& rows, const std::string& law_name, Format format, bool colour = false);
nlohmann::json to_json(const std::vector<CorrelationRow>& rows);

}  // namespace compare
