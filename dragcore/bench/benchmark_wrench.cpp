// One wrench() in both precisions and as reference::wrench(), beside the textbook loop; forces per triangle; a step of a free body.

#include "rows.hpp"

namespace dragcore::bench {

void add_drag_rows() {
  const std::vector<std::string> small{"cube-12", "ball-2048", "ball-12800", "sheet-3200"};
  for (const std::string& name : small)
    for (const std::string way : {"straight", "spinning"})
      add_row("textbook/" + name + "/" + way, [=](benchmark::State& state) {
        const Body& b = body(name);
        const IndexedMesh mesh(b.mesh);
        const Motion going = motion(way);
        Wrench found;
        for (auto _ : state) benchmark::DoNotOptimize(found = textbook(mesh, going, {}));
        count(state, static_cast<double>(mesh.triangles.size()));
        state.SetLabel(Hash().add(found).text());
      });

  std::vector<std::string> all = small;
  all.insert(all.end(), {"ball-100352", "ball-1002528"});
  const auto in = [](Precision precision) { return [precision](Model& model) { model.precision = precision; }; };
  add_wrench_rows({"single", all, in(Precision::single), 1e-6, [](const Body& b, const Motion& motion, Model model) {
                     model.precision = Precision::full;
                     return wrench(b.surface, motion, {}, model).total();
                   }});
  const auto reference = [](const Body& b, const Motion& motion, const Model& model) {
    return reference::wrench(b.mesh, b.surface.sides, motion, {}, model).total();
  };
  add_wrench_rows({"full", small, in(Precision::full), 1e-11, reference});
  add_row("wrench/reference/ball-2048/straight/class+pillow", [=](benchmark::State& state) {
    const Body& b = body("ball-2048");
    Wrench found;
    for (auto _ : state) found = reference(b, motion("straight"), model_for(b.surface));
    count(state, static_cast<double>(b.surface.size()));
    state.SetLabel(Hash().add(found).text());
  });

  add_step_rows("now");
  for (const std::string name : {"cube-12", "ball-2048", "ball-100352"})
    add_row("triangle_forces/" + name, [=](benchmark::State& state) {
      const Body& b = body(name);
      const Motion going = motion("spinning");
      const Model chosen = model_for(b.surface);
      TriangleForces found;
      for (auto _ : state) benchmark::DoNotOptimize((found = triangle_forces(b.surface, going, {}, chosen)).force.data());
      count(state, static_cast<double>(b.surface.size()));
      judge(state, "triangle_forces/" + name, {found.force.rowwise().sum(), found.torque.rowwise().sum()}, b.surface, going, 1e-6,
            [&] { return wrench(b.surface, going, {}, chosen).total(); });
    });
}

}  // namespace dragcore::bench
