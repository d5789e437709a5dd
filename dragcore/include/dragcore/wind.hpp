#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <dragcore/drag.hpp>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace dragcore {

/// Wind at a point: velocity and how it changes with place.
struct WindSample {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [m/s]
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();  ///< gradient(i, j) = d velocity_i / d x_j [1/s]
};

/// How much one field varies inside a ball, as upper bounds (turbulence: four standard deviations of its ensemble).
struct FieldVariation {
  double constant = 0.0;  ///< |u(x) - u(c)| inside the ball about c [m/s]
  double affine = 0.0;    ///< |u(x) - u(c) - G(c) (x - c)| [m/s]
  double slope = 0.0;     ///< |u(x) - u(y)| / |x - y| along segments that cross no discontinuity [1/s]
  double jump = 0.0;      ///< largest discontinuity: the edge of a grid that is zero outside [m/s]
};

/// What a grid answers beyond its box: nothing, or the value of the nearest point of the box.
enum class Outside { zero, clamp };

/// Velocities on a uniform grid of points. The first point of an axis lies at `lower`, the last at `upper`; an axis of one point is
/// constant from `lower` to `upper`.
struct Grid {
  Eigen::Vector3i points = Eigen::Vector3i::Ones();        ///< per axis, each >= 1
  Eigen::Vector3d lower = Eigen::Vector3d::Zero();         ///< [m]
  Eigen::Vector3d upper = Eigen::Vector3d::Ones();         ///< [m], above `lower` on every axis
  Eigen::Matrix3Xd values = Eigen::Matrix3Xd::Zero(3, 1);  ///< [m/s], one column per point, x fastest: column (k ny + j) nx + i
  Outside outside = Outside::zero;
};

struct PackedGrid;
struct PlacedGrid;

/// Trilinear interpolation of a grid: continuous inside, its gradient jumps at the planes of grid points (there the cell above is taken).
/// Points on the box's surface are inside. A point that is not a number gives a velocity that is not a number.
///
/// @accuracy  1e-15 of the largest value; exact at grid points
/// @source    [toskan2020] sec. 3.1; differs: guarded outside the box, any position and size of the box, one point per axis allowed
/// (erratum E26)
class GridField {
 public:
  /// @throws std::invalid_argument  if the number of values is not the product of the points, the box is empty or a value is not finite
  explicit GridField(Grid grid);

  const Grid& grid() const { return grid_; }
  const Eigen::Array3d& cells_per_metre() const { return cells_per_metre_; }
  /// What Wind samples in Precision::single: 16 bytes a point beside the 24 of the grid. Null where the library is built without kernels.
  const std::shared_ptr<const PackedGrid>& packed() const { return packed_; }
  Eigen::Vector3d velocity(const Eigen::Vector3d& point) const;
  WindSample sample(const Eigen::Vector3d& point) const;  ///< the gradient is the exact derivative of the interpolant

  /// Bounds over the axis-aligned box `radius * inverse_scale` about `centre`, from the values and differences of the cells it touches:
  /// cost grows with their number. `slope` is per unit of `radius`.
  FieldVariation variation(const Eigen::Vector3d& centre, double radius, const Eigen::Array3d& inverse_scale) const;

 private:
  Grid grid_;
  Eigen::Array3d cells_per_metre_;
  std::shared_ptr<const PackedGrid> packed_;
};

/// The same velocity everywhere.
struct UniformField {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [m/s]
};

/// Lamb-Oseen vortex about the z axis: swirl Gamma / (2 pi r) (1 - exp(-r^2/a^2)), solid rotation inside the core, free of divergence.
struct VortexField {
  double circulation = 0.0;  ///< Gamma, right-handed about z [m^2/s]
  double core_radius = 1.0;  ///< a > 0; the swirl is largest at 1.1209 a [m]
};

/// Turbulent round jet from a nozzle at the origin along +x: Gaussian profile of half-width b = d/sqrt(2) + 0.107 x, u_x = U b(0)/b
/// exp(-r^2/b^2), so that the momentum flux is that of the nozzle at every x > 0, and the radial inflow that makes it free of divergence
/// there. It fades out over one diameter upstream of the nozzle.
struct JetField {
  double exit_speed = 0.0;  ///< U [m/s]
  double diameter = 1.0;    ///< d > 0 [m]
};

class Turbulence;

using Field = std::variant<UniformField, VortexField, JetField, std::shared_ptr<const GridField>, std::shared_ptr<const Turbulence>>;

/// Where a field lies in the world: x_world = position + rotation * (scale .* x_field). Velocities are rotated and, where `scale` is
/// negative, mirrored with the field, but not stretched: their size is the source's `intensity`. The mirror (1, -1, 1) brings a left-handed
/// field into the right-handed world.
struct Placement {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< [m]
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< proper and orthonormal to 1e-9
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();         ///< per axis of the field, negative mirrors, never 0
};

/// One field in the world.
struct WindSource {
  std::string name;  ///< what animations address; sources that share a name form a group
  Field field = UniformField{};
  Placement placement{};
  double intensity = 1.0;  ///< factor on the velocity
  /// Distance from the field's origin, in its own frame, where it has faded to zero: the velocity is multiplied by (1 - (r/R)^2)^2.
  /// Infinite: no fading [m].
  double fade_radius = std::numeric_limits<double>::infinity();
};

/// Error bounds of the three ways to give a body its wind [m/s]. Bounds are rigorous except for turbulence (FieldVariation).
struct WindVariation {
  double constant = 0.0;      ///< the wind at the centre, everywhere
  double affine = 0.0;        ///< wind and gradient at the centre
  double per_triangle = 0.0;  ///< the wind at one point of each triangle
};

/// Cheapest first.
enum class WindSampling { constant, affine, per_triangle };

/// The cheapest way whose bound is within `tolerance` [m/s]; per_triangle when none is.
WindSampling choose_sampling(const WindVariation& variation, double tolerance);

/// All sources at one instant, summed; prepared for any number of points. World frame. Immutable, so any number of threads may sample it.
class Wind {
 public:
  /// @param time  seconds; only turbulence depends on it here, animations are played by WindController
  /// @throws std::invalid_argument  on a scale of zero, a rotation that is none, a radius that is not positive, anything that is not
  /// finite: the source's name,
  ///                                value found, value needed
  explicit Wind(const std::vector<WindSource>& sources, double time = 0.0);

  Eigen::Vector3d velocity(const Eigen::Vector3d& point) const;
  WindSample sample(const Eigen::Vector3d& point) const;

  /// Many points, 3 x n, one column each: sources whose bounding box misses the points' box are left out first. A point's velocity does
  /// not depend on the points beside it, so that any split of a batch gives the same bits.
  /// @param precision  `full`: the bits of velocity() point by point. `single`: grids are located in double and interpolated in
  ///                   single precision, 16 points at once, and turbulence has 8 points at once in double precision, where the library was
  ///                   built with its kernels (DRAGCORE_SIMD); all else as in `full`
  /// @accuracy  `single`: 1e-6 of the largest value (times intensity) of each grid at the point, wherever in the world
  ///            it lies (tests/dragcore/wind/test_grid_kernel.cpp); turbulence as Turbulence::velocities()
  Eigen::Matrix3Xd velocities(const Eigen::Ref<const Eigen::Matrix3Xd>& points, Precision precision = Precision::full) const;
  /// The same with gradients; turbulence is sampled point by point.
  /// @accuracy  `single`: gradients 1e-6 of the largest value over the smallest size of a cell
  std::vector<WindSample> samples(const Eigen::Ref<const Eigen::Matrix3Xd>& points, Precision precision = Precision::full) const;

  /// Error bounds inside the ball about `centre` [m], for triangles that reach at most `triangle_radius` from the point where each is
  /// sampled.
  /// @throws std::invalid_argument  if a radius is negative or anything is not finite
  WindVariation variation(const Eigen::Vector3d& centre, double radius, double triangle_radius = 0.0) const;

  /// Indices of the sources whose bounding box meets `box`, in order.
  std::vector<std::size_t> sources_near(const Eigen::AlignedBox3d& box) const;

 private:
  struct Placed {
    Field field;
    Eigen::Vector3d position;
    Eigen::Matrix3d to_field;  ///< S^-1 R^T
    Eigen::Matrix3d turn;      ///< intensity R sign(S)
    Eigen::Array3d inverse_scale;
    double intensity, fade_radius;
    Eigen::AlignedBox3d box;  ///< encloses where the field is not zero
    bool packed = false;      ///< it is one of `grids_`
  };

  template <bool with_gradient>
  void add(const Placed& source, const Eigen::Vector3d& point, WindSample& sum) const;
  void add_turbulence(const Placed& source, const Turbulence& turbulence, const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                      Eigen::Matrix3Xd& sum) const;

  std::vector<Placed> sources_;
  std::shared_ptr<const std::vector<PlacedGrid>> grids_;  ///< those sources that kernels sample; null where there are none
  double time_;
};

}  // namespace dragcore
