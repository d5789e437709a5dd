#include <cstdio>

#include "compare/store/store.hpp"
#include "tests/compare/sample_records.hpp"

/// Writes reference.h5, run.h5 and runs/*.h5 of made-up cases into a folder: something for other programs to read in tests.
int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_sample_reference FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  auto records = sample::quick_tier();
  records.push_back(sample::spinning("sphere_spin-z_re-4-laminar", dragcore::Sphere{}, {0.0, 0.0, 2.0}, -2.0, 4));
  std::filesystem::create_directories(folder / "cache" / "runs");
  for (const auto& record : records) compare::write_run(folder / "cache" / "runs" / (record.key + ".h5"), record);
  compare::write_run(folder / "run.h5", records.front());
  compare::write_reference(folder / "reference.h5", compare::merged({}, records), "test");
}
