#pragma once

#include <Eigen/Core>
#include <dragcore/mesh.hpp>
#include <dragcore/wrench.hpp>
#include <memory>
#include <string>
#include <vector>

/// What the drag models of other engines say of a body: run for real where the engine is installed, else a formula that says so.
namespace peers {

/// One body in one engine. Not to be called from two threads at once.
class Peer {
 public:
  virtual ~Peer() = default;

  /// @param wind  of the air, the body at rest; body frame [m/s]
  /// @return      force [N] and torque about the origin [N m], body frame
  virtual dragcore::Wrench wrench(const Eigen::Vector3d& wind) = 0;
};

struct Engine {
  std::string name;                                                                   ///< "MuJoCo box", ...
  bool reads_triangles = false;                                                       ///< or sees a box alone, whatever the mesh
  std::unique_ptr<Peer> (*make)(const dragcore::TriangleMesh& mesh, double density);  ///< density of the air [kg/m^3]
};

/// Those that are here: always Jolt's formula; MuJoCo's two models and Bullet where the program was built with them.
const std::vector<Engine>& engines();

/// Drag coefficient 1 on the box along the axes that holds the mesh, projected along the wind; the force acts at the middle of that box.
/// Jolt has no package in Debian: this is the formula of its buoyancy, drag 1, nothing of Jolt runs.
std::unique_ptr<Peer> jolt_formula(const dragcore::TriangleMesh& mesh, double density);

/// MuJoCo's default fluid model: a box with the inertia of the solid (of the skin, of an open mesh).
std::unique_ptr<Peer> mujoco_box(const dragcore::TriangleMesh& mesh, double density);

/// Its model by ellipsoid, with the default coefficients, on the box along the axes that holds the mesh.
std::unique_ptr<Peer> mujoco_ellipsoid(const dragcore::TriangleMesh& mesh, double density);

std::unique_ptr<Peer> bullet(const dragcore::TriangleMesh& mesh, double density);

/// A soft body of Bullet with the aerodynamics F_TwoSidedLiftDrag, the only one of its models that is a law of drag: drag coefficient 1, no
/// lift. Bullet limits what the air does to a node by the node's own speed, so that wind never moves a body at rest: the body moves.
class BulletMesh {
 public:
  explicit BulletMesh(const dragcore::TriangleMesh& mesh, double density = 1.225);
  ~BulletMesh();
  BulletMesh(BulletMesh&&) noexcept;
  BulletMesh& operator=(BulletMesh&&) noexcept;

  /// Forces on all nodes of the whole body moving through still air, in place of those before; with the normals of all faces, which Bullet
  /// makes anew at every step of a deforming body.
  void aerodynamic_forces(const Eigen::Vector3d& velocity);

  /// Places of the nodes, in the order of the mesh's vertices: the body as it is deformed.
  void move_to(const std::vector<Eigen::Vector3d>& vertices);

  dragcore::Wrench total() const;  ///< of the forces on all nodes, about the origin

 private:
  struct Body;
  std::unique_ptr<Body> body_;
};

}  // namespace peers
