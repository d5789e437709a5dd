#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/tables/error_table.hpp"

namespace compare {

/// The models that a gate watches: the note's law, alone and with pillows, the consistent and the scaled law, and the laws by class.
std::vector<NamedModel> gated_models();

/// The most by which errors may get worse, in units of the coefficients: half a percent of a coefficient of order one for a group, one
/// percent for a case. A baseline may hold smaller budgets; run_gate() refuses larger ones, which would pass anything.
constexpr double standing_group_budget = 0.005;
constexpr double standing_case_budget = 0.01;

/// What was accepted, with whose reason: predictions and errors of the gated models, and by how much they may get worse.
struct Baseline {
  struct Entry {
    std::optional<double> model, cfd;
    double u = 0.0;
  };
  struct Group {
    double rms = 0.0;
    double budget = 0.0;  ///< the rms error may grow by this
  };
  struct Model {
    std::map<std::string, std::map<std::string, Entry>> cases;   ///< case, channel
    std::map<std::string, std::map<std::string, Group>> groups;  ///< family, channel
  };
  struct Acceptance {
    std::string date, reason;
  };

  std::vector<Acceptance> history;   ///< oldest first; the last one is in force
  double case_budget = 0.0;          ///< the error of one case may grow by this, or by twice its u if that is more
  std::vector<std::string> planned;  ///< cases that must be compared
  std::map<std::string, Model> models;
};

/// The state of these records as a baseline. Budgets are kept from `previous` where it has them within the standing ones.
/// @throws std::invalid_argument when no case is usable or the reason is empty
Baseline make_baseline(const std::vector<case_record::CaseRecord>& records, const std::string& reason, const Baseline& previous = {});

/// @throws std::invalid_argument  when the file is missing (naming the command that makes one) or is not a baseline
Baseline read_baseline(const std::filesystem::path& path);
void write_baseline(const std::filesystem::path& path, const Baseline& baseline);

/// One line per case, channel, group or budget that differs by more than rounding; empty when nothing does.
std::vector<std::string> differences(const Baseline& before, const Baseline& after);

}  // namespace compare
