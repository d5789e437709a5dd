// Viscosity in the kernels against the same in double precision, on every instruction set that this machine has.

#include <Eigen/Eigenvalues>
#include <dragcore/batch.hpp>

#include "tests/dragcore/drag/hostile.hpp"
#include "tests/dragcore/kernels/targets.hpp"

using namespace dragcore;
using Eigen::Vector3d;

namespace {

Vector6d six(const Wrench& w) { return (Vector6d() << w.force, w.torque).finished(); }

}  // namespace

TEST_CASE("with viscosity the kernels give wrench and secant matrix within single precision, on bodies of every size and Re",
          "[kernels][backend][viscous]") {
  kernels::on_every_target([] {
    for (unsigned seed = 1; seed <= 300 / hostile::sanitizer_divisor; ++seed) {
      zoo::Random random(seed);
      INFO("seed " << seed);
      const Surface surface = zoo::surface(zoo::shapes()[seed % zoo::shapes().size()], 3);
      Model single = model_for(surface), full = zoo::exactly(single);
      single.quadrature = full.quadrature = seed % 3 ? Quadrature::three : Quadrature::adaptive;
      const Motion motion = seed % 2 ? random.motion(4.0, 0.0) : hostile::motion(random);
      const Medium medium{.density = 1.2, .viscosity = std::pow(10.0, random.uniform(-5.0, 2.0))};
      const WrenchByTerm exact = wrench(surface, motion, medium, full), fast = wrench(surface, motion, medium, single);
      // Coefficients of the boundary layer are of order sqrt(nu), those of creeping flow are summed in double.
      const double layer = 4.0 / std::sqrt(std::max(1e-9, medium.density * (motion.wind - motion.velocity).norm() / medium.viscosity));
      const double force = hostile::force_scale(surface, motion, medium.density) * (1.0 + layer), arm = hostile::arm_scale(surface, motion);
      for (std::size_t term = 0; term < exact.terms.size(); ++term) {
        INFO(to_string(static_cast<Term>(term)));
        const double size = exact.terms[term].force.norm(), moment = exact.terms[term].torque.norm();
        CHECK((fast.terms[term].force - exact.terms[term].force).norm() <= 1e-6 * (force + size));
        CHECK((fast.terms[term].torque - exact.terms[term].torque).norm() <= 1e-6 * (force * arm + moment));
      }
      const Matrix6d s = resistance(surface, motion, medium, single), t = resistance(surface, motion, medium, full);
      CHECK((s - t).norm() <= 1e-4 * t.norm());
      CHECK(Eigen::SelfAdjointEigenSolver<Matrix6d>(s).eigenvalues()[0] >= -1e-9 * s.norm());
      const Vector6d y = (Vector6d() << motion.wind - motion.velocity, -motion.angular_velocity).finished();
      CHECK(six(fast.total()).dot(y) >= -1e-6 * force * (y.head<3>().norm() + y.tail<3>().norm() * arm));
    }
  });
}

TEST_CASE("with viscosity a batch gives what its bodies get one by one, whatever the width of the vectors", "[kernels][batch][viscous]") {
  const std::vector<Surface> surfaces{zoo::surface(Box{}, 1), zoo::surface(Plate{.chord = 0.3, .span = 0.2, .thickness = 0.0}, 1),
                                      zoo::surface(Sphere{}, 1)};
  std::vector<Model> models;
  for (const Surface& surface : surfaces) models.push_back(model_for(surface));
  const MassProperties mass{0.1, Vector3d(0.02, 0.03, 0.04).asDiagonal()};
  const Medium medium{.density = 1.2, .viscosity = 0.02};  // Re of order 100
  kernels::same_bits([&] {
    zoo::Random random(61);
    std::vector<BodyInFlow> bodies;
    std::vector<FreeBody> free;
    for (std::size_t i = 0; i < 96; ++i) {
      const Motion motion = random.motion(5.0, i % 2 == 0 ? 0.0 : 3.0);
      bodies.push_back({&surfaces[i % 3], &models[i % 3], motion});
      free.push_back({.surface = &surfaces[i % 3], .model = &models[i % 3], .mass = &mass, .motion = motion});
    }
    std::vector<Wrench> found(bodies.size());
    std::vector<Vector6d> velocity(free.size());
    wrenches(bodies, medium, found);
    step_free_bodies(free, medium, 0.01, velocity);
    std::vector<double> all;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      Motion motion = bodies[i].motion;
      const Vector6d alone = six(wrench(surfaces[i % 3], motion, medium, models[i % 3]).total());
      CHECK((six(found[i]) - alone).norm() <= 1e-5 * alone.norm());  // each is 1e-6 of a force that the other rounds otherwise
      motion.angular_velocity = gyroscopic_spin(mass, motion.angular_velocity, 0.01);
      const Matrix6d s = resistance(surfaces[i % 3], motion, medium, models[i % 3]);
      const Vector6d moved = step_secant_implicit(s, mass, motion, Vector6d::Zero(), 0.01);
      CHECK((velocity[i] - moved).norm() <= 1e-5 * moved.norm());
      for (int k = 0; k < 6; ++k) all.push_back(six(found[i])[k]), all.push_back(velocity[i][k]);
    }
    return all;
  });
}
