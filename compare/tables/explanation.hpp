#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compare/calibration/prediction.hpp"
#include "compare/reference/case_of_record.hpp"
#include "compare/store/store.hpp"

namespace compare {

/// Which poses of which body.
struct PoseQuestion {
  std::string body;                     ///< "cube", or part of a label: "plate span=3"
  std::optional<double> incidence_deg;  ///< empty: whatever is stored
  std::optional<double> yaw_deg;
  double reynolds = 1e5;
};

/// "30" and "incidence 30", "yaw 45", "incidence 20 yaw 15"; also with = for the blank. @throws std::invalid_argument
PoseQuestion pose_question(const std::string& body, const std::string& pose, double reynolds);

/// What a reader asks of one number: how wrong is it, is that real, where does it come from, and what would be nearer at what price.
struct Explanation {
  std::string title;      ///< "cube, yaw 45°, Re 1e5"
  std::string case_name;  ///< of record
  std::string model_name;
  std::string method;                            ///< of the reference: "k_omega_sst, fine, 110,432 cells"
  double model = 0.0, reference = 0.0, u = 0.0;  ///< C_D; u one standard uncertainty, mesh and method included as far as known
  bool discretisation_assessed = false;
  struct Channel {
    std::string symbol;
    double error = 0.0, u = 0.0;
  };
  std::vector<Channel> also;                          ///< other channels whose error is real: beyond 2u and a hundredth
  double force_error = 0.0;                           ///< |F_model - F_reference| / |F_reference|
  std::string doubts;                                 ///< why the model may be wrong here, in its own words
  std::vector<std::pair<std::string, double>> terms;  ///< of the model's C_D, those beyond a hundredth of it, largest first
  struct Patch {
    std::string name;
    double model = 0.0, reference = 0.0;  ///< what the pressure on it adds to C_D
  };
  std::optional<Patch> worst_patch;  ///< where model and reference differ most; empty where no surface is stored
  struct Nearer {
    std::string name;
    double error = 0.0;                ///< of C_D, over the reference: of a law to the reference, of a mesh to the finest
    std::optional<double> cpu_s = {};  ///< of CFD
  };
  std::optional<Nearer> law;  ///< the nearest other model here
  std::optional<Nearer> cfd;  ///< the cheapest mesh with at most half the model's error

  double error() const { return model - reference; }
  bool resolved() const { return std::abs(error()) > 2.0 * u; }
};

/// One for each pose of record that the question asks for.
/// @throws std::invalid_argument  no such body or pose: those that there are
std::vector<Explanation> explain_error(const Reference& reference, const NamedModel& model, const std::vector<NamedModel>& others,
                                       const PoseQuestion& question);

std::string render(const Explanation& explanation);  ///< five lines below a title
nlohmann::json to_json(const Explanation& explanation);

}  // namespace compare
