#include <dragcore/field_file.hpp>

#include "fuzz.hpp"

/// Wind fields as FGA text: what is accepted can be sampled, and written and read again without a change.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dragcore;
  static const fuzz::Scratch scratch(".fga");
  const auto& file = scratch.holding(data, size);
  try {
    const GridField field = read_fga(file);
    const Grid& grid = field.grid();
    const Eigen::Vector3d middle = 0.5 * grid.lower + 0.5 * grid.upper;
    const WindSample sample = field.sample(middle);
    if (grid.values.cwiseAbs().maxCoeff() < 1e100) fuzz::check(sample.velocity.allFinite(), "a field is finite inside its box");
    field.variation(middle, 1.0, Eigen::Array3d::Ones());
    write_fga(file, field);
    const Grid back = read_fga(file).grid();
    fuzz::check(back.points == grid.points && back.lower == grid.lower && back.upper == grid.upper && back.values == grid.values,
                "a field that was read can be written and read again");
    write_fga(file, field, {.order = FgaOrder::z_fastest});
    fuzz::check(read_fga(file, {.order = FgaOrder::z_fastest}).grid().values == grid.values, "the order of the axes comes back");
    scratch.holding(data, size);
    read_fga(file, {.length_m = 0.01,
                    .speed_m_s = 0.01,
                    .points = FgaPoints::cell_centres,
                    .order = FgaOrder::z_fastest,
                    .outside = Outside::clamp,
                    .thickness_m = 0.5});
  } catch (const std::runtime_error& fault) {
    fuzz::check(std::strlen(fault.what()) < 1000, "a message is short");
  }
  return 0;
}
