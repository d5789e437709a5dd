// dragcore in engines that are left-handed (Unity, Unreal) or count in centimetres (Unreal): docs/embedding.md.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <dragcore/drag.hpp>
#include <dragcore/mass_properties.hpp>
#include <dragcore/shapes.hpp>

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// How an engine's frame becomes dragcore's, right-handed and in metres: r = metres * axes * r_engine, for the world and every body alike.
struct EngineFrame {
  Matrix3d axes;  // orthogonal; determinant -1 for a left-handed engine
  double metres;  // length of the engine's unit

  Vector3d polar(const Vector3d& v) const { return metres * axes * v; }                   // positions, velocities, wind
  Vector3d axial(const Vector3d& w) const { return axes.determinant() * axes * w; }       // spin [rad/s]
  Matrix3d rotation(const Matrix3d& body_to_world) const { return axes * body_to_world * axes.transpose(); }

  Vector3d force(const Vector3d& f) const { return axes.transpose() * f / metres; }       // N to kg unit/s^2
  Vector3d torque(const Vector3d& t) const { return axes.determinant() * axes.transpose() * t / (metres * metres); }
};

const EngineFrame unreal{Vector3d(1, -1, 1).asDiagonal().toDenseMatrix(), 0.01};               // x forward, y right, z up
const EngineFrame unity{(Matrix3d() << 1, 0, 0, 0, 0, 1, 0, 1, 0).finished(), 1.0};        // x right, y up, z forward

/// A mesh as the engine has it, its front faces wound either way.
dragcore::TriangleMesh from_engine(const EngineFrame& engine, const dragcore::TriangleMesh& mesh) {
  dragcore::TriangleMesh result = transformed(mesh, engine.metres * engine.axes, Vector3d::Zero());
  if (inspect(result).inside_out)
    for (auto& triangle : result.triangles) std::swap(triangle[1], triangle[2]);
  return result;
}

struct EngineBody {           // as the engine has it: its units, its world's axes
  Vector3d velocity, spin;    // of the centre of mass, the origin of the body
  Eigen::Quaterniond turn;    // Eigen's constructor takes w, x, y, z; the engines store x, y, z, w
};

/// Force and torque in the engine's units and its world's axes, for its AddForce and AddTorque.
dragcore::Wrench engine_wrench(const EngineFrame& engine, const dragcore::Surface& surface, const EngineBody& body, const Vector3d& wind) {
  const Matrix3d to_world = engine.rotation(body.turn.normalized().toRotationMatrix()), to_body = to_world.transpose();
  const dragcore::Motion motion{.wind = to_body * engine.polar(wind), .velocity = to_body * engine.polar(body.velocity),
                                .angular_velocity = to_body * engine.axial(body.spin)};
  const dragcore::Wrench air = wrench(surface, motion, {.density = 1.2}, model_for(surface)).total();
  return {engine.force(to_world * air.force), engine.torque(to_world * air.torque)};
}

bool close(const Vector3d& found, const Vector3d& expected) { return (found - expected).norm() < 1e-9 * expected.norm(); }

int main() {
  int wrong = 0;
  const auto check = [&wrong](bool good, const char* what) { wrong += !good, std::printf("%s: %s\n", good ? "holds" : "WRONG", what); };
  for (const EngineFrame& engine : {unreal, unity}) {
    // A cone and how it flies, in dragcore's frame, and the same as the engine would have it.
    const dragcore::TriangleMesh cone = triangulate(dragcore::Cone{}, 6);
    const dragcore::TriangleMesh given = transformed(cone, engine.axes.transpose() / engine.metres, Vector3d::Zero());
    const Vector3d wind(3, 1, 2), velocity(-6, 2, 1), spin(2, -3, 4);
    const Matrix3d to_world = Eigen::AngleAxisd(0.8, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    const EngineBody body{engine.axes.transpose() * velocity / engine.metres, engine.axes.determinant() * engine.axes.transpose() * spin,
                          Eigen::Quaterniond(engine.axes.transpose() * to_world * engine.axes)};
    const Vector3d engine_wind = engine.axes.transpose() * wind / engine.metres;

    const dragcore::Surface surface(from_engine(engine, given)), same(cone);
    const dragcore::Wrench found = engine_wrench(engine, surface, body, engine_wind);
    const dragcore::Motion motion{.wind = to_world.transpose() * wind, .velocity = to_world.transpose() * velocity,
                                  .angular_velocity = to_world.transpose() * spin};
    const dragcore::Wrench air = wrench(same, motion, {.density = 1.2}, model_for(same)).total();
    check(close(found.force, engine.axes.transpose() * (to_world * air.force) / engine.metres), "the force is dragcore's");
    // Handedness shows in the velocity of a point and in power: both as the engine's own formulas have them.
    const Vector3d arm(20, 30, -10), moved = body.spin.cross(arm);
    check(close(engine.polar(moved), spin.cross(engine.polar(arm))), "a point of the body moves as the engine says");
    const double power = velocity.dot(to_world * air.force) + spin.dot(to_world * air.torque);
    const double engine_power = (found.force.dot(body.velocity) + found.torque.dot(body.spin)) * engine.metres * engine.metres;
    check(std::abs(engine_power / power - 1) < 1e-9, "the power of force and torque is the same");
  }

  // A cube of 100 cm in a wind of 1000 cm/s from behind: some 60 N, 6000 kg cm/s^2, forwards; and its spin is braked.
  const dragcore::Surface cube(triangulate(dragcore::Box{}, 4));
  const dragcore::Wrench push = engine_wrench(unreal, cube, {Vector3d::Zero(), {0, 0, 3}, Eigen::Quaterniond::Identity()}, {1000, 0, 0});
  check(push.force.x() > 5000 && push.force.x() < 7000 && push.torque.z() < 0, "a cube in Unreal's units");

  // Unreal's quaternions: the axial part changes its sign but for y.
  const Eigen::Quaterniond q(0.5, 0.1, -0.7, 0.5), mirrored(q.w(), -q.x(), q.y(), -q.z());
  check(unreal.rotation(q.normalized().toRotationMatrix()).isApprox(mirrored.normalized().toRotationMatrix(), 1e-12), "a quaternion");
  return wrong;
}
