#include <BulletSoftBody/btSoftBody.h>

#include <Eigen/Geometry>
#include <stdexcept>

#include "compare/peers/peers.hpp"

namespace peers {
namespace {

btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
Eigen::Vector3d from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

btAlignedObjectArray<btVector3> places(const dragcore::TriangleMesh& mesh) {
  btAlignedObjectArray<btVector3> list;
  for (const Eigen::Vector3d& vertex : mesh.vertices) list.push_back(to_bullet(vertex));
  return list;
}

}  // namespace

struct BulletMesh::Body {
  btSoftBodyWorldInfo world;
  btAlignedObjectArray<btVector3> start;
  btSoftBody soft;

  Body(const dragcore::TriangleMesh& mesh, double density)
      : start(places(mesh)), soft(&world, start.size(), start.size() > 0 ? &start[0] : nullptr, nullptr) {  // nodes of 1 kg
    world.air_density = static_cast<btScalar>(density);
    for (const Eigen::Vector3i& triangle : mesh.triangles) soft.appendFace(triangle[0], triangle[1], triangle[2]);
    soft.m_cfg.aeromodel = btSoftBody::eAeroModel::F_TwoSidedLiftDrag;
    soft.m_cfg.kDG = 1;
    soft.m_cfg.kLF = 0;
    soft.m_sst.sdt = btScalar(1e-6);  // short: the limit by a node's own speed is far away
  }
};

BulletMesh::BulletMesh(const dragcore::TriangleMesh& mesh, double density) {
  dragcore::validate(mesh);
  body_ = std::make_unique<Body>(mesh, density);
}
BulletMesh::~BulletMesh() = default;
BulletMesh::BulletMesh(BulletMesh&&) noexcept = default;
BulletMesh& BulletMesh::operator=(BulletMesh&&) noexcept = default;

void BulletMesh::aerodynamic_forces(const Eigen::Vector3d& velocity) {
  btSoftBody& soft = body_->soft;
  const btVector3 v = to_bullet(velocity), still(0, 0, 0);
  for (int i = 0; i < soft.m_nodes.size(); ++i) {
    soft.m_nodes[i].m_v = v;
    soft.m_nodes[i].m_f = still;
  }
  soft.updateNormals();
  for (int i = 0; i < soft.m_faces.size(); ++i) soft.addAeroForceToFace(still, i);
}

void BulletMesh::move_to(const std::vector<Eigen::Vector3d>& vertices) {
  btSoftBody& soft = body_->soft;
  if (vertices.size() != static_cast<std::size_t>(soft.m_nodes.size()))
    throw std::invalid_argument("BulletMesh: " + std::to_string(vertices.size()) + " vertices, but the body has " +
                                std::to_string(soft.m_nodes.size()) + " nodes: give one place for each");
  for (int i = 0; i < soft.m_nodes.size(); ++i) soft.m_nodes[i].m_x = to_bullet(vertices[static_cast<std::size_t>(i)]);
}

dragcore::Wrench BulletMesh::total() const {
  const btSoftBody& soft = body_->soft;
  dragcore::Wrench sum;
  for (int i = 0; i < soft.m_nodes.size(); ++i) {
    const Eigen::Vector3d force = from_bullet(soft.m_nodes[i].m_f);
    sum += {force, from_bullet(soft.m_nodes[i].m_x).cross(force)};
  }
  return sum;
}

std::unique_ptr<Peer> bullet(const dragcore::TriangleMesh& mesh, double density) {
  class SoftBody : public Peer {
   public:
    SoftBody(const dragcore::TriangleMesh& triangles, double air) : mesh_(triangles, air) {}
    dragcore::Wrench wrench(const Eigen::Vector3d& wind) override {
      mesh_.aerodynamic_forces(-wind);
      return mesh_.total();
    }

   private:
    BulletMesh mesh_;
  };
  return std::make_unique<SoftBody>(mesh, density);
}

}  // namespace peers
