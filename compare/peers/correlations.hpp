#pragma once

#include <Eigen/Core>
#include <dragcore/shapes.hpp>
#include <optional>
#include <string>
#include <vector>

namespace peers {

/// A convex body in a flow, as drag correlations of particles see it. The ball of equal volume is what it is measured by.
struct Particle {
  double diameter = 0.0;    ///< d_v, of that ball [m]
  double sphericity = 1.0;  ///< surface of the ball / of the body
  double crosswise = 1.0;   ///< pi d_v^2 / 4 over the silhouette along the wind
  double lengthwise = 1.0;  ///< pi d_v^2 / 4 over (half the body's surface - its mean silhouette across the wind)
};

/// @param wind  where the air goes, body frame, any length > 0
/// @return      empty for what has no volume, and for a body given by triangles, which may be hollowed
std::optional<Particle> particle(const dragcore::Shape& shape, const Eigen::Vector3d& wind);

/// A published correlation: drag alone. C_D stands on pi d_v^2 / 4, Re on d_v.
struct Correlation {
  std::string name;
  std::string citation;    ///< key in references.bib
  bool ball_only = false;  ///< says nothing of other bodies
  double (*drag)(double reynolds, const Particle& particle);
};

/// Below the drag crisis. Their formulas were checked against other programs that have them, none against the papers themselves.
///
/// Haider and Levenspiel: by sphericity alone; in the limit of Stokes every body drags like the ball of equal volume. The same in OpenFOAM
/// (NonSphereDragForce) and Ansys Fluent's theory guide.
///
/// Ganser: by sphericity and, in the limit of Stokes, the diameter of the circle as large as the silhouette (bodies that are not
/// isometric). Without its term for walls. The same in MFiX (SuperDEM) and PYFLOW; others have the isometric form.
///
/// Hoelzer and Sommerfeld: by all three sphericities. As in MFiX, which has the crosswise sphericity for the lengthwise one. The last term
/// is 0.42 10^(0.4 (-lg Phi)^0.2): PYFLOW and others read a power of 0.4210, from a lost raised exponent.
///
/// Clift and Gauvin: the ball, to Re 3e5. The same in PYFLOW and in the documentation of AnkusDrive's drag screen.
const std::vector<Correlation>& correlations();

}  // namespace peers
