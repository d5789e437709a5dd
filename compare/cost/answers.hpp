#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/cost/ladder.hpp"
#include "compare/tables/text_grid.hpp"

// What a ladder says: the shortest way to an error, and what the next one costs.

namespace compare {

/// A rung is nearer than another when its error is this much smaller: less is no reason to pay more.
inline constexpr double nearer = 0.98;

/// The rungs that nothing cheaper is as near as, in order of cost; of those that answer half of the poses at least.
std::vector<const Rung*> pareto_front(const std::vector<Rung>& rungs);

/// From one rung of the front to the next.
struct FrontStep {
  const Rung *from = nullptr, *to = nullptr;
  double times_cost = 1.0;
  double halving_cost = 1.0;  ///< what half the error would cost at this pace: times_cost^(ln 2 / ln(error / error))
};
std::vector<FrontStep> front_steps(const std::vector<const Rung*>& front);

/// From each rung to the cheapest that has half its error, as long as there is one.
std::vector<FrontStep> halvings(const std::vector<const Rung*>& front);

/// Who reaches a wanted error, and for how much.
struct TargetAnswer {
  double target = 0.0;                                  ///< of the force vector, over the rms force of its body
  const Rung *law = nullptr, *cfd = nullptr;            ///< the cheapest that reach it, without CFD and with it; nullptr where none does
  const Rung *best_law = nullptr, *best_cfd = nullptr;  ///< the nearest; nullptr where there is none
};
TargetAnswer reach(const Ladder& ladder, double target);

/// "1.4 ns", "23 \u00b5s", "1.2 h"
std::string time_text(double seconds);

/// "\u00d7 3.2", "\u00d7 1e7"
std::string times_text(double factor);

/// The first lines: which rung for what error, and what the next halving costs.
std::string answer(const Ladder& ladder);
std::string answer(const Ladder& ladder, const TargetAnswer& found);

struct CostTable {
  std::string id, caption;
  TextGrid grid;
  std::string note = {};  ///< below it
};
/// Front, ablation, triangles, spin, step; those that have rows.
std::vector<CostTable> cost_tables(const Ladder& ladder);
CostTable all_rungs(const Ladder& ladder);

nlohmann::json to_json(const Ladder& ladder);
nlohmann::json to_json(const TargetAnswer& found);

}  // namespace compare
