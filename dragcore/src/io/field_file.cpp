#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <dragcore/field_file.hpp>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "io/hdf5_file.hpp"
#include "io/text.hpp"

namespace dragcore {

namespace {

using Eigen::Vector3d;

// A grid of 512^3 points takes 3 GB: anything above is taken for a damaged header, not for a reason to ask for all the machine's memory.
constexpr double most_points = 512.0 * 512.0 * 512.0;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& fault) {
  throw std::runtime_error("wind field file " + file.string() + ": " + fault);
}

/// The grid of a file, its faults reported with the file's name.
GridField checked(const std::filesystem::path& file, Grid grid) {
  try {
    return GridField(std::move(grid));
  } catch (const std::invalid_argument& fault) {
    fail(file, fault.what());
  }
}

bool is_separator(char c) { return c == ',' || c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

std::string text_of(const std::filesystem::path& file) {
  std::string bytes;
  try {
    bytes = bytes_of(file);
  } catch (const std::runtime_error& fault) {
    fail(file, fault.what());
  }
  if (is_utf16(bytes)) fail(file, "is text in UTF-16; save it as UTF-8 or ASCII");
  return bytes;
}

/// The numbers of a text, in order; reads nothing past its end.
class Numbers {
 public:
  Numbers(const std::filesystem::path& file, std::string_view text) : file_(file), rest_(without_mark(text)), size_(text.size()) {}

  bool at_end() {
    while (!rest_.empty() && is_separator(rest_.front())) rest_.remove_prefix(1);
    return rest_.empty();
  }

  double next(const std::string& what) {
    if (at_end()) fail(file_, "ends where " + what + " is needed; it is truncated, export it again");
    const std::string_view word =
        rest_.substr(0, static_cast<std::size_t>(std::find_if(rest_.begin(), rest_.end(), is_separator) - rest_.begin()));
    const std::optional<double> value = number_of<double>(word);
    if (!value || !std::isfinite(*value))
      fail(file_, "has " + in_quotes(word) + " at byte " + std::to_string(size_ - rest_.size()) + ", where " + what +
                      " is needed: not a finite number");
    rest_.remove_prefix(word.size());
    return *value;
  }

  Vector3d next_vector(const std::string& what) {
    Vector3d v;
    for (int a = 0; a < 3; ++a) v[a] = next(what);
    return v;
  }

 private:
  const std::filesystem::path& file_;
  std::string_view rest_;
  std::size_t size_;
};

void check(const char* function, const FgaMeaning& meaning) {
  for (const auto& [name, unit] : {std::pair{"length_m", meaning.length_m}, std::pair{"speed_m_s", meaning.speed_m_s}})
    if (!(unit > 0.0) || !std::isfinite(unit))
      throw std::invalid_argument(std::string(function) + ": " + name + " = " + std::to_string(unit) +
                                  ", but it must be greater than 0 and finite");
  if (!(meaning.thickness_m >= 0.0) || !std::isfinite(meaning.thickness_m))
    throw std::invalid_argument(std::string(function) + ": thickness_m = " + std::to_string(meaning.thickness_m) +
                                ", but it must be 0 or greater, and finite");
}

/// Calls visit(column of Grid::values) for each point in the order of the file.
template <class Visit>
void for_each_point(const Eigen::Vector3i& points, FgaOrder order, const Visit& visit) {
  const Eigen::Index nx = points[0], ny = points[1], nz = points[2];
  if (order == FgaOrder::x_fastest) {
    for (Eigen::Index column = 0; column < nx * ny * nz; ++column) visit(column);
  } else {
    for (Eigen::Index i = 0; i < nx; ++i)
      for (Eigen::Index j = 0; j < ny; ++j)
        for (Eigen::Index k = 0; k < nz; ++k) visit((k * ny + j) * nx + i);
  }
}

/// Widens a flat box, whose bounds are equal along an axis of one point, to `thickness`, or to its widest cell where that is 0 [m].
void thicken(const std::filesystem::path& file, const Eigen::Vector3i& points, double thickness, Vector3d& lower, Vector3d& upper) {
  const auto flat = [&, from = lower, to = upper](int a) { return points[a] == 1 && from[a] == to[a]; };
  if (!flat(0) && !flat(1) && !flat(2)) return;
  if (thickness == 0.0)
    for (int a = 0; a < 3; ++a)
      if (!flat(a)) thickness = std::max(thickness, (upper[a] - lower[a]) / std::max(1, points[a] - 1));
  if (thickness == 0.0) fail(file, "its lower and upper bounds are equal, so that the field has no size; needed: bounds apart");
  for (int a = 0; a < 3; ++a)
    if (flat(a)) lower[a] -= 0.5 * thickness, upper[a] += 0.5 * thickness;
}

/// Half of a cell that the file's bounds reach beyond the outermost points, or 0; `from_bounds` when the size given is that of the bounds.
Vector3d overhang(const FgaMeaning& meaning, const Eigen::Vector3i& points, const Vector3d& size, bool from_bounds) {
  if (meaning.points == FgaPoints::on_bounds) return Vector3d::Zero();
  Vector3d half;
  // One point fills its only cell: it is constant between the bounds either way.
  for (int a = 0; a < 3; ++a) half[a] = points[a] == 1 ? 0.0 : 0.5 * size[a] / (from_bounds ? points[a] : points[a] - 1);
  return half;
}

}  // namespace

GridField read_fga(const std::filesystem::path& file, const FgaMeaning& meaning) {
  check("read_fga", meaning);
  const std::string text = text_of(file);
  Numbers numbers(file, text);
  Grid grid;
  grid.outside = meaning.outside;
  double count = 1.0;
  for (int a = 0; a < 3; ++a) {
    const double points = numbers.next("a number of points");
    if (!(points >= 1.0 && points <= most_points && points == std::floor(points)))
      fail(file,
           "its number of points along axis " + std::to_string(a) + " reads " + std::to_string(points) + "; needed: a whole number from 1");
    grid.points[a] = static_cast<int>(points);
    count *= points;
  }
  // A number and its separator take two bytes: a file that promises more vectors than it has room for is not worth allocating for.
  if (count > most_points || 6.0 * count > static_cast<double>(text.size()) + 1.0)
    fail(file, "promises " + std::to_string(grid.points[0]) + " x " + std::to_string(grid.points[1]) + " x " +
                   std::to_string(grid.points[2]) + " vectors, but has only " + std::to_string(text.size()) +
                   " bytes; it is truncated or no FGA file");
  const Vector3d lower = meaning.length_m * numbers.next_vector("the lower bound"),
                 upper = meaning.length_m * numbers.next_vector("the upper bound");
  const Vector3d half = overhang(meaning, grid.points, upper - lower, true);
  grid.lower = lower + half;
  grid.upper = upper - half;
  thicken(file, grid.points, meaning.thickness_m, grid.lower, grid.upper);
  grid.values.resize(3, static_cast<Eigen::Index>(count));
  Eigen::Index read = 0;
  for_each_point(grid.points, meaning.order, [&](Eigen::Index column) {
    grid.values.col(column) =
        meaning.speed_m_s * numbers.next_vector("vector " + std::to_string(++read) + " of " + std::to_string(grid.values.cols()));
  });
  if (!numbers.at_end())
    fail(file,
         "goes on after its last vector, number " + std::to_string(grid.values.cols()) + "; its first line does not fit its contents");
  return checked(file, std::move(grid));
}

std::vector<std::string> write_fga(const std::filesystem::path& file, const GridField& field, const FgaMeaning& meaning) {
  check("write_fga", meaning);
  const Grid& grid = field.grid();
  std::string text;
  const auto line = [&](const Vector3d& v) {
    for (int a = 0; a < 3; ++a) {
      std::array<char, 32> word;
      text.append(word.data(), std::to_chars(word.data(), word.data() + word.size(), v[a]).ptr).append(a < 2 ? "," : ",\n");
    }
  };
  const Vector3d half = overhang(meaning, grid.points, grid.upper - grid.lower, false);
  line(grid.points.cast<double>());
  line((grid.lower - half) / meaning.length_m);
  line((grid.upper + half) / meaning.length_m);
  for_each_point(grid.points, meaning.order, [&](Eigen::Index column) { line(grid.values.col(column) / meaning.speed_m_s); });
  std::ofstream out(file, std::ios::binary);
  if (!(out << text).flush()) fail(file, "cannot be written; check the folder and the free space");
  std::vector<std::string> notes;
  constexpr int most_in_unreal = 128;
  for (int a = 0; a < 3; ++a)
    if (grid.points[a] > most_in_unreal)
      notes.push_back(std::to_string(grid.points[a]) + " points along " + "xyz"[a] + ": Unreal takes " + std::to_string(most_in_unreal) +
                      " at most. Write fewer if the file is meant for it");
  return notes;
}

namespace {

constexpr const char* schema = "dragcore.wind_field";

}  // namespace

GridField read_field_hdf5(const std::filesystem::path& path) {
  const hdf5::File file{"wind field", path};
  hdf5::Reader reader(file, schema);
  Grid grid;
  const std::string outside = reader.text("outside");
  if (outside != "zero" && outside != "clamp") fail(file, "attribute outside is '" + outside + "'; needed: 'zero' or 'clamp'");
  grid.outside = outside == "zero" ? Outside::zero : Outside::clamp;
  for (const auto& [name, bound] : {std::pair{"lower", &grid.lower}, std::pair{"upper", &grid.upper}})
    reader.numbers<double>(name, "m", [&, n = name, b = bound](const std::vector<hsize_t>& shape) {
      if (shape != std::vector<hsize_t>{3}) fail(file, std::string("dataset ") + n + " has shape " + hdf5::to_text(shape) + "; needed: [3]");
      return b->data();
    });
  reader.numbers<double>("velocity", "m/s", [&](const std::vector<hsize_t>& shape) {
    double count = 1.0;
    for (const hsize_t n : shape) count *= static_cast<double>(n);
    if (shape.size() != 4 || shape[3] != 3 || count < 3.0 || count > 3.0 * most_points)
      fail(file, "dataset velocity has shape " + hdf5::to_text(shape) + "; needed: [nz, ny, nx, 3] with 1 to 512^3 points");
    grid.points = {static_cast<int>(shape[2]), static_cast<int>(shape[1]), static_cast<int>(shape[0])};
    grid.values.resize(3, static_cast<Eigen::Index>(count / 3.0));
    return grid.values.data();
  });
  return checked(path, std::move(grid));
}

void write_field_hdf5(const std::filesystem::path& path, const GridField& field) {
  const Grid& grid = field.grid();
  hdf5::write({"wind field", path}, schema, [&](const hdf5::File& file, hid_t root) {
    hdf5::write_text(file, root, "outside", grid.outside == Outside::zero ? "zero" : "clamp");
    hdf5::write_numbers(file, root, "lower", {3}, grid.lower.data(), "m", "field", "position of the first grid point");
    hdf5::write_numbers(file, root, "upper", {3}, grid.upper.data(), "m", "field", "position of the last grid point");
    const Eigen::Array3<hsize_t> n = grid.points.cast<hsize_t>().array();
    hdf5::write_numbers(file, root, "velocity", {n[2], n[1], n[0], 3}, grid.values.data(), "m/s", "field",
                        "wind velocity at the grid points, indices z, y, x, component");
  });
}

}  // namespace dragcore
