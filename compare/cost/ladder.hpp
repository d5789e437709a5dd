#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/calibration/calibration.hpp"
#include "compare/case_record/case_record.hpp"

namespace compare {

/// Root-mean-square errors over poses, each in coefficients.
struct RmsErrors {
  double relative = 0.0;  ///< of the force vector, over the rms force of the same body: every body counts alike
  double drag = 0.0;      ///< of C_D
  double force = 0.0;     ///< of the vector (C_D, C_S, C_L)
  double torque = 0.0;    ///< of (C_l, C_m, C_n)
};

/// One way to find the force on a body: how wrong it is, and what an answer costs.
struct Rung {
  std::string name;        ///< "class, pillow", "MuJoCo box", "k_omega_sst, fine"
  std::string kind;        ///< "constant", "engine", "law" or "CFD"
  double triangles = 0.0;  ///< mean over the poses; cells of CFD; 0 where the body is but an area
  double seconds = 0.0;    ///< CPU time of one evaluation, mean over the poses
  RmsErrors errors;
  int poses = 0;
};

/// An effect of the best law taken away.
struct Ablation {
  std::string effect;
  RmsErrors errors;
  double seconds = 0.0;
};

/// A round body on a mesh: how far its facets leave the force from that of the finest.
struct MeshStep {
  std::string body;
  double triangles = 0.0, seconds = 0.0;
  double force_ratio = 1.0;  ///< drag over drag on the finest mesh
};

/// Points per triangle for bodies that spin.
struct SpinStep {
  std::string rule;
  double triangles = 0.0, seconds = 0.0;
  double rule_error = 0.0;  ///< rms of torque, over the rms torque by six points
  double cfd_error = 0.0;   ///< rms of torque about the axis, over that of the references
  int cases = 0;
};

/// What a time step needs besides the force.
struct StepCost {
  std::string what, body;
  double triangles = 0.0, seconds = 0.0;
};

/// What ending a steady solution early saves and leaves.
struct Stopping {
  double left = 0.0;  ///< rms drift that remains at the stop, over the force
  int poses = 0;
  std::optional<double> longer_cost_low, longer_cost_high;  ///< CPU time of 800 iterations instead, over the usual; empty without studies
  double longer_change = 0.0;                               ///< largest change of C_D by them, over C_D
};

/// All of it, on the same poses and the same references.
struct Ladder {
  std::string body;  ///< the only kind of body; empty: all
  int poses = 0, bodies = 0;
  RmsErrors uncertainty;    ///< of the references: one standard uncertainty, the part of their method included
  std::vector<Rung> rungs;  ///< in no order of cost
  std::vector<Ablation> ablation;
  std::vector<MeshStep> meshes;
  std::vector<SpinStep> spin;
  std::vector<StepCost> steps;
  Stopping stopping;

  const Rung* rung(const std::string& name) const;  ///< the first of this name; nullptr when there is none
};

/// Name of the recommended model on the meshes that errors are stated for. On others ", n = 4" follows: at most so many segments of a
/// quarter turn, or of an edge.
inline constexpr const char* best_law = "class, pillow";

struct LadderOptions {
  const Calibration* calibration = nullptr;            ///< adds the fitted law and pillows
  std::vector<case_record::CaseRecord> spinning = {};  ///< references of bodies that spin
  std::vector<case_record::CaseRecord> studies = {};   ///< variants of the numerics, as `dragval variants` takes them
  std::string body = {};                               ///< kind of the only body, or a part of its label: "cone", "plate span=3"
  bool quick = false;                                  ///< fewer repetitions and meshes, for tests and reports
};

/// Every rung on every usable turbulent case of record at Re >= 1e4. Times are measured now, CPU seconds, best of several.
///
/// CFD at the mesh levels that were solved, with the CPU time that they took: its error is that of the mesh, the distance from the case of
/// record and the numerical u of that; what the equations leave open is in `uncertainty` alone. Of a pose whose record was found by another
/// method it is the distance. Where nobody knows what the mesh does to the record, its whole u stands for it.
/// @throws std::invalid_argument  for a body that no reference has: the message lists those that there are
Ladder measure_ladder(const std::vector<case_record::CaseRecord>& records, const LadderOptions& options = {});

}  // namespace compare
