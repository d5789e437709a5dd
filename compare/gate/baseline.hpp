#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "compare/tables/error_table.hpp"

namespace compare {

/// The models that a gate watches unless told: the note's law, alone and with pillows, the consistent and the scaled law, and the laws by
/// class.
std::vector<NamedModel> gated_models();

/// predict() bound to the model's choice.
Predictor predictor_of_choice(const NamedModel& named);

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
  std::map<std::string, std::array<double, 6>> seed_scatter;  ///< case, channel: standard deviation of the coefficient over mesh seeds
};

/// How far apart two solutions of one case on meshes of different seeds may lie, in standard deviations over seeds: five times that of a
/// difference, which is sqrt(2) times that of a value.
constexpr double seed_factor = 5.0 * std::numbers::sqrt2;

/// A case on a mesh of another seed: "cube_re-1e5_coarse_seed-7" is the case "cube_re-1e5_coarse" with seed 7. Seed 0: any other name.
struct SeededName {
  std::string base;
  int seed = 0;
};
SeededName seeded_name(const std::string& case_name);

/// Seeds up to this one are what gate_odds() judges; those above say what scatter is allowed, so that the two do not know each other.
constexpr int judged_seeds = 100;

/// Standard deviations over the meshes of each case with seeds above `judged_seeds`, where five or more are usable.
std::map<std::string, std::array<double, 6>> scatter_over_seeds(const std::vector<case_record::CaseRecord>& records);

/// The state of these records as a baseline. Budgets are kept from `previous` where it has them within the standing ones, and so is the
/// scatter over seeds.
/// @throws std::invalid_argument when no case is usable or the reason is empty
Baseline make_baseline(const std::vector<case_record::CaseRecord>& records, const std::string& reason, const Baseline& previous = {},
                       const std::vector<NamedModel>& models = gated_models());

/// @throws std::invalid_argument  when the file is missing (naming the command that makes one) or is not a baseline
Baseline read_baseline(const std::filesystem::path& path);
void write_baseline(const std::filesystem::path& path, const Baseline& baseline);

/// One line per case, channel, group or budget that differs by more than rounding; empty when nothing does.
std::vector<std::string> differences(const Baseline& before, const Baseline& after);

}  // namespace compare
