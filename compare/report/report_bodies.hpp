#pragma once

#include "compare/report/report.hpp"

namespace compare {

/// What the page shows of bodies in three dimensions, for bodies.js:
///
///   shapes  name; vertices and triangles of the body, the patch of each triangle; names of the patches
///   cases   index of the shape, words on flow and pose, rotation from body to wind frame; C_p of every patch, and the six coefficients:
///           of OpenFOAM, and of each model; u of its C_D
///   errors  rms relative error of C_D by law, class of body and range of Re, fitted and unseen: what to expect of a body of one's own
///
/// Cases of record with their patches stored, at rest. The laws count pressure from that of a face parallel to the flow; of a closed body a
/// constant adds nothing to force and torque, so a model's C_p has the constant `gauge` taken off which makes its mean over the area
/// OpenFOAM's.
nlohmann::json report_bodies(const Report& report);

}  // namespace compare
