#include <cstdio>
#include <dragcore/drag.hpp>
#include <dragcore/shapes.hpp>

int main() {
  const dragcore::Surface cone(triangulate(dragcore::Cone{}, 8));            // or any TriangleMesh; prepared once
  const dragcore::Motion motion{.wind = {10, 0, 2}, .angular_velocity = {0, 0, 5}};
  const dragcore::Model model = model_for(cone);                             // or {.law = dragcore::note_law()}, or a law of your own
  const dragcore::Wrench air = wrench(cone, motion, {.density = 1.2}, model).total();   // force [N], torque [N m]
  std::printf("a cone in a wind of 10 m/s: %.1f N downwind, %.1f N m against its spin\n", air.force.x(), -air.torque.z());

  // For a check: the note's law gives a cube of 1 m^2 C_D = 1.
  const dragcore::Surface cube(triangulate(dragcore::Box{}, 1));
  return wrench(cube, {.wind = {10, 0, 0}}, {.density = 1.2}, {}).total().force.x() == 60.0 && air.torque.z() < 0.0 ? 0 : 1;
}
