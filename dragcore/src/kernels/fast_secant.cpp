#include "drag/secant.hpp"
#include "drag/viscous.hpp"
#include "kernels/part_flow.hpp"
#include "kernels/secant_kernel.hpp"
#include "support/cross_matrix.hpp"

namespace dragcore {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using kernels::SecantSums;

namespace {

Matrix3d symmetric_from(const double* six) {
  Matrix3d m;
  m << six[0], six[1], six[2], six[1], six[3], six[4], six[2], six[4], six[5];
  return m;
}

/// About the origin of the part, in the kernels' units.
Eigen::Matrix<double, 6, 6> matrix(const SecantSums& sums) {
  const double* row = sums.row.data();
  const Matrix3d normal = symmetric_from(row + SecantSums::normal), moment = symmetric_from(row + SecantSums::moment),
                 second = symmetric_from(row + SecantSums::rubbed_second),
                 mixed = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(row + SecantSums::mixed);
  const Matrix3d turn = cross_matrix(Eigen::Map<const Vector3d>(row + SecantSums::rubbed_first));
  Eigen::Matrix<double, 6, 6> s;
  s.topLeftCorner<3, 3>() = normal + row[SecantSums::rubbed] * Matrix3d::Identity();
  s.topRightCorner<3, 3>() = mixed - turn;
  s.bottomLeftCorner<3, 3>() = s.topRightCorner<3, 3>().transpose();
  s.bottomRightCorner<3, 3>() = moment + second.trace() * Matrix3d::Identity() - second;
  s.topLeftCorner<3, 3>().diagonal().array() += SecantSums::rounding * s.topLeftCorner<3, 3>().trace();
  s.bottomRightCorner<3, 3>().diagonal().array() += SecantSums::rounding * s.bottomRightCorner<3, 3>().trace();
  return s;
}

}  // namespace

std::optional<Secant> fast_secant(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  if (!kernels::know(surface, model)) return std::nullopt;
  kernels::BodyFlow flow(surface, motion, medium, model);
  Secant result;
  kernels::PartFlow part;
  for (std::size_t p = 0; p < surface.parts.size(); ++p) {
    if (!flow.of(p, part)) return std::nullopt;
    if (part.speed == 0.0) continue;
    if (!flow.varies()) part.task.quadrature = model.effects.has(Effect::spin) ? model.quadrature : Quadrature::one;
    part.task.varies = true;
    const SecantSums sums = kernels::secant_sums(part.task);
    // From the part's origin to the reference point, and to newtons per metre per second.
    Eigen::Matrix<double, 6, 6> move = Eigen::Matrix<double, 6, 6>::Identity();
    move.bottomRightCorner<3, 3>() *= part.size;
    move.bottomLeftCorner<3, 3>() = cross_matrix(part.arm);
    const double unit = part.to_newton / part.speed;
    result.taken += unit * move * matrix(sums) * move.transpose();
    const double* given = sums.row.data() + SecantSums::given;
    const Wrench pushed = part.in_newton(Eigen::Map<const Vector3d>(given), Eigen::Map<const Vector3d>(given + 3));
    result.given.head<3>() += pushed.force, result.given.tail<3>() += pushed.torque;
    result.given_power += part.to_newton * part.speed * sums.row[SecantSums::given_power];
  }
  for_each_creeping_flow(surface, motion, medium, model, [&](const Part& creeping_part, const CreepingFlow& creeping) {
    result.taken += creeping.matrix(creeping_part);
  });
  result.taken = 0.5 * (result.taken + result.taken.transpose()).eval();  // to the last bit
  return result;
}

}  // namespace dragcore
