// A square of cloth, held along one edge in a wind. The engine's solver is a few lines here: explicit steps, edges that keep their length.
#include <cstdio>
#include <dragcore/deforming.hpp>
#include <dragcore/shapes.hpp>
#include <vector>

using Eigen::Vector3f;

int main() {
  const dragcore::TriangleMesh mesh = triangulate(dragcore::Plate{.chord = 1.0, .span = 1.0, .thickness = 0.0}, 12);
  std::vector<Vector3f> position, velocity(mesh.vertices.size(), Vector3f::Zero()), force(velocity);  // the engine's own
  for (const Eigen::Vector3d& r : mesh.vertices) position.push_back(r.cast<float>());
  const std::vector<Vector3f> start = position;
  const auto held = [&](std::size_t v) { return start[v].x() < -0.499f; };

  dragcore::DeformingMesh cloth(mesh.triangles, position.size(), dragcore::Surface::Sides::two);  // once
  const dragcore::Law law = dragcore::sheet_law();

  const float dt = 1.0f / 480.0f, mass = 0.3f / static_cast<float>(position.size());  // 0.3 kg/m^2
  for (int step = 0; step < 960; ++step) {
    cloth.forces(position, velocity, {4, 0.5, 0}, {.density = 1.2}, law, force);  // wind in the world [m/s]; force on every vertex [N]
    const std::vector<Vector3f> before = position;
    for (std::size_t v = 0; v < position.size(); ++v)
      if (!held(v)) position[v] += dt * (velocity[v] + dt * (force[v] / mass + Vector3f(0, 0, -9.81f)));
    for (int pass = 0; pass < 20; ++pass)
      for (const Eigen::Vector3i& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
          const auto a = static_cast<std::size_t>(t[k]), b = static_cast<std::size_t>(t[(k + 1) % 3]);
          const float share_a = held(a) ? 0.0f : 1.0f, share_b = held(b) ? 0.0f : 1.0f;
          if (share_a + share_b == 0.0f) continue;
          const Vector3f edge = position[b] - position[a];
          const Vector3f excess = (1.0f - (start[b] - start[a]).norm() / edge.norm()) / (share_a + share_b) * edge;
          position[a] += share_a * excess, position[b] -= share_b * excess;
        }
    for (std::size_t v = 0; v < position.size(); ++v) velocity[v] = (position[v] - before[v]) / dt;
  }
  Vector3f end = Vector3f::Zero();
  float count = 0.0f;
  for (std::size_t v = 0; v < position.size(); ++v)
    if (start[v].x() > 0.499f) end += position[v], count += 1.0f;
  end /= count;
  std::printf("the free edge is %.2f m downwind of the held one and %.2f m below it\n", end.x() + 0.5f, -end.z());
  return end.x() > -0.4f && end.x() < 0.55f && end.z() < -0.01f && end.z() > -1.05f ? 0 : 1;
}
