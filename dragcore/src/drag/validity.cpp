#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dragcore/descriptors.hpp>
#include <dragcore/validity.hpp>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "body/extents.hpp"
#include "drag/check.hpp"
#include "drag/corrected_flow.hpp"
#include "drag/relative_flow.hpp"

namespace dragcore {

namespace {

using Eigen::Vector3d;

std::string text(double value) {
  std::ostringstream out;
  out.precision(2);
  out << value;
  return out.str();
}

PrincipalBox box_of(const Surface& surface, std::size_t part) {
  std::vector<Eigen::Index> members;
  for (Eigen::Index i = 0; i < surface.size(); ++i)
    if (RelativeFlow::part_of(surface, i) == part) members.push_back(i);
  return principal_box(static_cast<Eigen::Index>(members.size()), [&](Eigen::Index k) -> std::array<Vector3d, 3> {
    const Eigen::Index i = members[static_cast<std::size_t>(k)];
    const Vector3d ab = surface.edge_ab.row(i).matrix(), ac = surface.edge_ac.row(i).matrix();
    const Vector3d a = surface.centroid.row(i).matrix().transpose() - (ab + ac) / 3.0;
    return {a, a + ab, a + ac};
  });
}

}  // namespace

std::string to_string(Doubt doubt) {
  switch (doubt) {
    case Doubt::low_reynolds:
      return "low Reynolds number";
    case Doubt::not_exposed:
      return "not exposed";
    case Doubt::concave:
      return "concave";
    case Doubt::spin:
      return "spin";
    case Doubt::stalling_sheet:
      return "stalling sheet";
    case Doubt::edge_on_sheet:
      return "edge-on sheet";
    case Doubt::elongated:
      return "elongated";
    case Doubt::smooth_body:
      return "smooth body";
    case Doubt::uneven_wind:
      return "uneven wind";
    case Doubt::drag_crisis:
      return "drag crisis";
    case Doubt::not_calibrated:
      return "not calibrated";
  }
  throw std::invalid_argument("not a doubt");
}

Validity validity(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model, double viscosity) {
  check_input(surface, motion, medium, model);
  Validity found;
  if (surface.size() == 0) return found;
  const auto doubt = [&](Doubt kind, const std::string& reason) {
    found.doubts |= static_cast<unsigned>(kind);
    found.reasons.push_back(reason);
  };
  const auto main = static_cast<std::size_t>(
      std::max_element(surface.parts.begin(), surface.parts.end(), [](const Part& a, const Part& b) { return a.area < b.area; }) -
      surface.parts.begin());
  const Part& part = surface.parts[main];
  const ActiveEffects active(motion, model);
  const RelativeFlow flow(surface, motion, active);
  const double travel = flow.at_centre(main).norm(), spin = motion.angular_velocity.norm() * surface.radius;
  const double speed = travel + spin;

  const double known = medium.viscosity > 0.0 ? medium.viscosity : viscosity;
  const double reynolds = known > 0.0 ? medium.density * speed * 2.0 * surface.radius / known : 0.0;
  if (ActiveEffects(motion, model, model.law_of(part.body_class), {}, medium).has<Effect::viscous>()) {
    if (reynolds > 200.0 && reynolds < 1e4)
      doubt(Doubt::low_reynolds, "Re is " + text(reynolds) + "; between 200 and 1e4 the law is too draggy, a ball by 10 to 33 %");
    if (reynolds > 2e5 && part.body_class == BodyClass::smooth)
      doubt(Doubt::drag_crisis, "Re is " + text(reynolds) +
                                    ": on a round body above 2e5 to 3e5 the flow separates later and drag falls to a quarter, which no law here has");
  } else if (known > 0.0) {
    if (speed > 0.0 && reynolds < 1e4)
      doubt(Doubt::low_reynolds, "Re is " + text(reynolds) + "; the laws are fitted at 1e5 and lack the friction of anything below 1e4");
  }
  const bool corrected = is_corrected(model);
  if (corrected && reynolds > 0.0 &&
      (3.0 * reynolds < model.correction->least_reynolds || reynolds > 3.0 * model.correction->most_reynolds))
    doubt(Doubt::not_calibrated, "Re is " + text(reynolds) + "; this body was calibrated from " + text(model.correction->least_reynolds) +
                                     " to " + text(model.correction->most_reynolds));
  if (!surface.convex && !surface.exposed)
    doubt(Doubt::not_exposed, "the mesh is not convex, and nobody looked which walls stand in the wind of others: use expose()");
  if (!surface.convex && surface.exposed && !surface.exposure)
    doubt(Doubt::concave, "not one convex body, to which the laws are fitted, though all of it meets the wind");
  // What the wind does not reach, along this direction: the flow there is nothing that a law of convex bodies knows.
  if (surface.exposure && travel > 0.0) {
    const Exposure::Sample sample = surface.exposure->towards(-flow.at_centre(main));
    double facing = 0.0, reached = 0.0;
    for (Eigen::Index i = 0; i < surface.size(); ++i) {
      double c = -flow.at_centre(main).dot(surface.normal.row(i).matrix().transpose()) / travel;
      if (surface.back[i] > 0.0) c = std::abs(c);
      if (!(c > 0.0)) continue;
      facing += surface.area[i] * c;
      reached += surface.area[i] * c * surface.exposure->share(i, sample);
    }
    doubt(Doubt::concave, reached < 0.999 * facing
                              ? text(100.0 * (1.0 - reached / facing)) + " % of the windward area stands behind other parts"
                              : "not one convex body, to which the laws are fitted, though nothing stands in the lee of anything here");
  }
  if (spin > travel && spin > 0.0) doubt(Doubt::spin, "points move faster by spin than by travel; torques of spin are 15 to 65 % too low");
  if (speed > 0.0 && motion.wind_gradient.norm() * surface.radius > travel / 3.0)
    doubt(Doubt::uneven_wind, "the wind varies over the body by more than a third of the speed");
  // What a class does not know of shapes is what a calibration finds of one.
  if (!(travel > 0.0) || corrected) return found;

  const Vector3d direction = flow.at_centre(main) / travel;
  const PrincipalBox box = box_of(surface, main);
  const auto degrees = [](double radians) { return radians * 180.0 / std::numbers::pi; };
  if (part.body_class == BodyClass::sheet) {
    const double incidence = degrees(std::asin(std::min(1.0, std::abs(direction.dot(box.axes.col(0))))));
    if (incidence < 5.0)
      doubt(Doubt::edge_on_sheet, "a sheet within 5 degrees of edge-on: its force is that of edge and friction, which the law has not");
    if (incidence > 17.0 && incidence < 48.0)
      doubt(Doubt::stalling_sheet,
            "a sheet at " + text(incidence) + " degrees: between 17 and 48 the law is fitted to steady RANS, a quarter too low");
  } else if (part.body_class == BodyClass::smooth) {
    doubt(Doubt::smooth_body, "a round body: the law does not know where the flow separates, and its drag crisis not at all");
  } else if (box.extents[2] > 1.8 * box.extents[1]) {
    const double angle = degrees(std::acos(std::min(1.0, std::abs(direction.dot(box.axes.col(2))))));
    if (angle > 3.0 && angle < 22.0)
      doubt(Doubt::elongated, "a long body at " + text(angle) +
                                  " degrees to its axis: the flow lies down again on its sides, and half of the side force is missing");
  }
  return found;
}

}  // namespace dragcore
