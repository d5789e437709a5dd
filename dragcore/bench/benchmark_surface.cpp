// Preparing a mesh: time, and the bytes that stay allocated, by the allocator's own books: Eigen takes memory past operator new.

#include <malloc.h>

#include "rows.hpp"

namespace dragcore::bench {

namespace {

double allocated_bytes() {
  const struct mallinfo2 books = mallinfo2();
  return static_cast<double>(books.uordblks + books.hblkhd);
}

}  // namespace

void add_surface_rows() {
  for (const std::string name : {"cube-12", "ball-2048", "ball-100352"})
    add_row("surface/" + name, [=](benchmark::State& state) {
      const Body& b = body(name);
      for (auto _ : state) benchmark::DoNotOptimize(Surface(b.mesh).total_area);
      const double before = allocated_bytes();
      const Surface surface(b.mesh);
      state.counters["bytes_per_triangle"] = (allocated_bytes() - before) / static_cast<double>(surface.size());
      count(state, static_cast<double>(surface.size()));
      state.SetLabel(
          Hash().add(surface.normal).add(surface.centroid).add(surface.area).add(surface.second_moment).add(surface.curvature).text());
    })->Unit(benchmark::kMillisecond);
}

}  // namespace dragcore::bench
