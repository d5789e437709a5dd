#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/tables/error_table.hpp"

namespace compare {

/// A difference in one channel: in % of the base's force (of its moment, for a moment), and in units of the base's u_disc in that channel.
struct Change {
  std::optional<double> percent;  ///< empty where the base's force, or moment, is nearly nothing
  std::optional<double> in_u;     ///< empty where u_disc is not known
};

/// A case that differs from a base case in nothing but the variant: numerics, seed of the mesh, far field, start.
struct VariantRow {
  std::string base, variant;  ///< names of the base case and of the variant: "cube_re-1e5_medium", "upwind"
  std::string status, reason;
  Change drag, lateral,
      moment;  ///< C_D; C_L or, at yaw, C_S; C_m or C_n. Of a body that spins in still air only the moment, about the axis
  std::optional<double> cpu_ratio;  ///< CPU time over the base's
  int iterations = 0;
};

/// Scatter over meshes that differ in the seed alone (variants "seed-2", "seed-3", ... and the base): standard deviation.
struct SeedScatter {
  std::string base;
  int n = 0;
  Change drag, lateral, moment;
};

struct VariantTable {
  std::vector<VariantRow> rows;
  std::vector<SeedScatter> seeds;
  std::vector<std::string> without_base;  ///< cases with a variant whose base was not solved
  int compared = 0;                       ///< rows with both sides
};

/// @param records  bodies at rest and bodies that spin, at any mesh levels: a variant is compared with its base on the same level
VariantTable variant_table(const std::vector<case_record::CaseRecord>& records);

std::string render(const VariantTable& table, Format format, bool colour = false);
nlohmann::json to_json(const VariantTable& table);

}  // namespace compare
