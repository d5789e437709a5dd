#pragma once

#include <dragcore/drag.hpp>
#include <dragcore/validity.hpp>
#include <functional>
#include <string>

#include "compare/case_record/case_record.hpp"

namespace compare {

/// Divisions for triangulate(): 2 for flat-sided shapes, on which force and patch-level pillow do not depend on the mesh; 32 for round
/// ones, where the error of the faceted surface is below 0.3 % (second order, tests/compare/calibration/test_prediction.cpp).
int default_divisions(const dragcore::Shape& shape);

/// The surface that a model sees of a body: every prediction, fit and cost measurement takes it from here. A plate without thickness
/// feels the wind on both sides; a body of triangles is prepared and exposed as a file would be.
dragcore::Surface surface_of(const dragcore::Shape& shape, int divisions);

/// The same, made once for each shape and resolution and kept: a report evaluates each of them thousands of times.
const dragcore::Surface& prepared_surface(const dragcore::Shape& shape, int divisions);

/// Of a case, body frame: the wind of its pose, unless the air is still, and its spin.
dragcore::Motion motion_of(const case_record::CaseRecord& record);

/// With the case's viscosity: the law at its Reynolds number.
dragcore::Medium medium_of(const case_record::CaseRecord& record);

/// One model for every body, or the law that suits the class of each (dragcore::law_for), with one pillow for all or that of the class.
struct ModelChoice {
  dragcore::Model model{};
  bool by_class = false;         ///< the law is chosen by the body; `model.law` is not used
  bool pillow_by_class = false;  ///< so is the pillow (dragcore::class_pillow)

  ModelChoice() = default;  ///< the note's law
  ModelChoice(const dragcore::Model& fixed) : model(fixed) {}
  static ModelChoice of_class(const dragcore::Pillow& pillow = {});
  static ModelChoice recommended();  ///< what dragcore::model_for() gives

  std::string pillow_label() const;  ///< "tilt pillow 0.78", "tilt pillow by class"; empty without one

  dragcore::Model on(const dragcore::Surface& surface) const;
};

/// A model under the name that tables and baselines give it.
struct NamedModel {
  std::string name;
  ModelChoice choice;
};

/// What the drag model says about a case: body in the pose, wind along +x of the wind frame (none in still air), at the case's speed, spin
/// and density.
/// @param divisions  of the triangulation; 0 takes default_divisions()
/// @return           force [N] and moment about the body's centroid [N m], wind frame, by term
dragcore::WrenchByTerm predict(const case_record::CaseRecord& record, const ModelChoice& choice, int divisions = 0);

/// What is known of the laws by class at the pose and Reynolds number of a case.
dragcore::Validity validity(const case_record::CaseRecord& record);

/// Any model: what a comparison asks. predict() bound to a drag law is one, a table of somebody else's numbers another.
using Predictor = std::function<dragcore::Wrench(const case_record::CaseRecord&)>;
Predictor predictor(const ModelChoice& choice, int divisions = 0);

}  // namespace compare
