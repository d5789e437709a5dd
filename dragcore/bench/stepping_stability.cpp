// A sheet of paper thrown at random: share of throws that gain energy relative to the air, and the error of the velocity after half a
// second, for an explicit step and the three of stepping.hpp. Markdown table on stdout; seeded.

#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <dragcore/shapes.hpp>
#include <dragcore/stepping.hpp>
#include <functional>
#include <random>
#include <vector>

using namespace dragcore;
using Eigen::Vector3d;

int main() {
  const Surface paper(triangulate(Plate{0.1, 0.1, 0.0}, 2), Surface::Sides::two);
  const double m = 8e-4, a = 0.1;  // 80 g/m^2
  const MassProperties body{m, Vector3d(m * a * a / 12, m * a * a / 12, m * a * a / 6).asDiagonal()};
  const Matrix6d mass = body.matrix(), inverse = mass.inverse();
  const Model model{.pillow = {PillowForm::tilt, 0.8}};
  using Update = std::function<Vector6d(const Motion&, double)>;
  const auto wrench_of = [&](const Motion& motion) {
    const Wrench w = wrench(paper, motion, {}, model).total();
    return Vector6d((Vector6d() << w.force, w.torque).finished());
  };
  const auto velocity_of = [](const Motion& motion) {
    return Vector6d((Vector6d() << motion.velocity, motion.angular_velocity).finished());
  };
  const std::vector<std::pair<const char*, Update>> updates = {
      {"explicit Euler", [&](const Motion& motion, double dt) { return Vector6d(velocity_of(motion) + dt * inverse * wrench_of(motion)); }},
      {"secant-implicit",
       [&](const Motion& motion, double dt) {
         return step_secant_implicit(resistance(paper, motion, {}, model), body, motion, Vector6d::Zero(), dt);
       }},
      {"scalar-implicit",
       [&](const Motion& motion, double dt) {
         return step_scalar_implicit(resistance(paper, motion, {}, model), body, motion, Vector6d::Zero(), dt);
       }},
      {"impulse share", [&](const Motion& motion, double dt) {
         const Wrench w = wrench(paper, motion, {}, model).total();
         return Vector6d(velocity_of(motion) + impulse_share(w, body, motion, dt) * dt * inverse * wrench_of(motion));
       }}};
  const auto run = [&](const Update& update, Motion motion, double dt, double& gained) {
    double energy = velocity_of(motion).dot(mass * velocity_of(motion));
    for (int step = 0, steps = static_cast<int>(std::lround(0.5 / dt)); step < steps; ++step) {
      const Vector6d v = update(motion, dt);
      const double after = v.dot(mass * v);
      if (!(after <= energy * (1 + 1e-12))) gained = 1.0;
      if (!std::isfinite(after) || after > 1e12 * energy) return Vector6d(Vector6d::Constant(1e9));
      energy = after;
      motion.velocity = v.head<3>();
      motion.angular_velocity = v.tail<3>();
    }
    return velocity_of(motion);
  };
  std::printf("| time step |");
  for (const auto& [name, update] : updates) std::printf(" %s |", name);
  std::printf("\n|---|");
  for (std::size_t i = 0; i < updates.size(); ++i) std::printf("---|");
  std::printf("\n");
  for (const int rate : {240, 120, 60, 30, 15}) {
    std::printf("| 1/%d s |", rate);
    for (const auto& [name, update] : updates) {
      std::mt19937 engine(1);
      std::normal_distribution<double> normal;
      const auto direction = [&] { return Vector3d(normal(engine), normal(engine), normal(engine)).normalized(); };
      double gains = 0.0, error = 0.0;
      constexpr int throws = 40;
      for (int i = 0; i < throws; ++i) {
        const Motion motion{.velocity = 15.0 * direction(), .angular_velocity = 40.0 * direction()};
        double gained = 0.0, ignored = 0.0;
        const Vector6d fine = run(updates[1].second, motion, 1.0 / 7680, ignored), coarse = run(update, motion, 1.0 / rate, gained);
        gains += gained;
        error += std::min(1.0, std::pow((coarse - fine).head<3>().norm() / fine.head<3>().norm(), 2.0));
      }
      std::printf(" %.0f of %d gain energy, error %.1f %% |", gains, throws, 100.0 * std::sqrt(error / throws));
    }
    std::printf("\n");
  }
}
