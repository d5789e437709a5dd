// resistance() by the kernels against the same in double precision.

#include <Eigen/Eigenvalues>
#include <dragcore/stepping.hpp>

#include "tests/dragcore/drag/hostile.hpp"
#include "tests/dragcore/kernels/targets.hpp"

using namespace dragcore;
using Eigen::Vector3d;

namespace {

Vector6d relative_velocity(const Motion& motion) {
  return (Vector6d() << motion.wind - motion.velocity, -motion.angular_velocity).finished();
}

}  // namespace

TEST_CASE("the kernels give the secant matrix within single precision, and never a negative one", "[kernels][backend][stepping]") {
  kernels::on_every_target([&] {
    for (unsigned seed = 1; seed <= 1200 / hostile::sanitizer_divisor; ++seed) {
      INFO("seed " << seed);
      zoo::Random random(seed);
      const hostile::Body body = hostile::body(random, false);
      const Surface surface = body.surface();
      const Motion motion = hostile::motion(random);
      Model model = hostile::model(random, false, false);
      model.pillow = seed % 2 == 0 ? Pillow{} : Pillow{PillowForm::tilt, 1.4};
      if (seed % 3 == 0) model = model_for(surface);
      model.precision = Precision::single;
      const Matrix6d fast = resistance(surface, motion, {}, model), exact = resistance(surface, motion, {}, zoo::exactly(model));
      // In units of the largest drag by the largest speed, and of the arm for torques.
      const double force = hostile::force_scale(surface, motion, Medium{}.density), arm = hostile::arm_scale(surface, motion);
      const double speed = std::sqrt(force / (0.5 * Medium{}.density * 2.0 * surface.total_area + 1e-300));
      if (!(speed > 0.0)) continue;
      const Vector6d unit = (Vector6d() << Vector3d::Ones(), Vector3d::Constant(1.0 / arm)).finished();
      const Matrix6d one = unit.asDiagonal() * fast * unit.asDiagonal() * speed / force,
                     other = unit.asDiagonal() * exact * unit.asDiagonal() * speed / force;
      // What pushes enters by its square root: where a body is pushed as much as held, digits cancel. So each must be right by what it is
      // for: the wrench.
      CHECK(fast == fast.transpose());
      CHECK(Eigen::SelfAdjointEigenSolver<Matrix6d>(one, Eigen::EigenvaluesOnly).eigenvalues()[0] >= -1e-13 * one.norm());
      const Vector6d velocity = unit.cwiseInverse().asDiagonal() * relative_velocity(motion) / speed;
      CHECK(((one - other) * velocity).norm() <= 1e-5);  // ten roundings on faces edge-on, whose normals decide by their last bit
      Model holds = model;                               // nothing pushes: no square roots
      holds.effects = holds.effects.without(Effect::curvature | Effect::recovery);
      const Matrix6d difference = resistance(surface, motion, {}, holds) - resistance(surface, motion, {}, zoo::exactly(holds));
      CHECK((unit.asDiagonal() * difference * unit.asDiagonal() * speed / force).norm() <= 1e-5);
    }
  });
}

TEST_CASE("the secant matrix has the same bits whatever the width of the vectors", "[kernels][backend][stepping]") {
  kernels::same_bits([] {
    zoo::Random random(42);
    std::vector<double> all;
    for (const Shape& shape : zoo::shapes()) {
      const Surface surface = zoo::surface(shape, 4);
      for (const Law& law : hostile::laws())
        for (const Quadrature order : {Quadrature::three, Quadrature::adaptive}) {
          const Model model{.law = law, .pillow = {PillowForm::tilt, 0.7}, .quadrature = order, .precision = Precision::single};
          const Matrix6d s = resistance(surface, random.motion(5.0, 2.0), {}, model);
          all.insert(all.end(), s.data(), s.data() + s.size());
        }
    }
    return all;
  });
}
