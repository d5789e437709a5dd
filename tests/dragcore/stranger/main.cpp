#include <cstdio>
#include <dragcore/drag.hpp>
#include <dragcore/shapes.hpp>

int main() {
  const dragcore::Surface cube(triangulate(dragcore::Box{}, 1));
  const dragcore::Motion motion{.wind = {10.0, 0.0, 0.0}};
  const Eigen::Vector3d force = dragcore::wrench(cube, motion, {.density = 1.2}, {}).total().force;
  std::printf("drag of a cube in a wind of 10 m/s: %.1f N\n", force.x());
  return force.x() == 60.0 ? 0 : 1;  // C_D = 1: half of 1.2 x 100
}
