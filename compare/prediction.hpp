#pragma once

#include <dragcore/drag.hpp>
#include <functional>

#include "compare/case_record/case_record.hpp"

namespace compare {

/// Divisions for triangulate(): 2 for flat-sided shapes, on which force and patch-level pillow do not depend on the mesh; 32 for round
/// ones, where the error of the faceted surface is below 0.3 % (second order, tests/compare/test_prediction.cpp).
int default_divisions(const dragcore::Shape& shape);

/// What the drag model says about a case: body at rest in the pose, wind along +x of the wind frame, at the case's speed and density.
/// A plate without thickness is two-sided.
/// @param divisions  of the triangulation; 0 takes default_divisions()
/// @return           force [N] and moment about the body's centroid [N m], wind frame, by term
dragcore::WrenchByTerm predict(const case_record::CaseRecord& record, const dragcore::Model& model, int divisions = 0);

/// Any model: what a comparison asks. predict() bound to a drag law is one, a table of somebody else's numbers another.
using Predictor = std::function<dragcore::Wrench(const case_record::CaseRecord&)>;
Predictor predictor(const dragcore::Model& model, int divisions = 0);

}  // namespace compare
