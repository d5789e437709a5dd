#include <hdf5.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <dragcore/field_file.hpp>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

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

/// An HDF5 identifier that closes itself; the call that made it is named when it failed.
class Handle {
 public:
  Handle(const std::filesystem::path& file, hid_t id, herr_t (*close)(hid_t), const std::string& fault) : id_(id), close_(close) {
    if (id < 0) fail(file, fault);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { close_(id_); }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Our messages name file and remedy; the library's own trace on stderr is switched off meanwhile.
class Quiet {
 public:
  Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &client_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, function_, client_); }

 private:
  H5E_auto2_t function_ = nullptr;
  void* client_ = nullptr;
};

constexpr const char* schema = "dragcore.wind_field";
constexpr const char* schema_version = "1.0";

void write_text(const std::filesystem::path& file, hid_t object, const char* name, const std::string& text) {
  const Handle type(file, H5Tcopy(H5T_C_S1), H5Tclose, "no text type");
  H5Tset_size(type, text.size());
  H5Tset_cset(type, H5T_CSET_UTF8);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  const Handle space(file, H5Screate(H5S_SCALAR), H5Sclose, "no data space");
  const Handle attribute(file, H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                         std::string("cannot create attribute ") + name);
  if (H5Awrite(attribute, type, text.data()) < 0) fail(file, std::string("cannot write attribute ") + name);
}

/// A text attribute of fixed length; empty when there is none.
std::string read_text(const std::filesystem::path& file, hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return {};
  const Handle attribute(file, H5Aopen(object, name, H5P_DEFAULT), H5Aclose, std::string("cannot open attribute ") + name);
  const Handle space(file, H5Aget_space(attribute), H5Sclose, "no data space");
  const Handle type(file, H5Aget_type(attribute), H5Tclose, "no type");
  if (H5Tget_class(type) != H5T_STRING || H5Sget_simple_extent_npoints(space) != 1)
    fail(file, std::string("attribute ") + name + " is not a text");
  // Those of variable length are kept in a heap without checksums, in which HDF5 1.10 loops for ever where it is damaged.
  if (H5Tis_variable_str(type) > 0)
    fail(file,
         std::string("attribute ") + name + " is a text of variable length; write it with a fixed one, in Python as numpy.bytes_('…')");
  std::string text(H5Tget_size(type), '\0');
  if (H5Aread(attribute, type, text.data()) < 0) fail(file, std::string("cannot read attribute ") + name);
  return text.substr(0, text.find('\0'));
}

void write_numbers(const std::filesystem::path& file, hid_t parent, const char* name, const std::vector<hsize_t>& shape,
                   const double* values, const char* units, const char* long_name) {
  const Handle space(file, H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose, "no data space");
  const Handle properties(file, H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "no properties");
  H5Pset_obj_track_times(properties, false);  // same contents, same bytes
  H5Pset_chunk(properties, static_cast<int>(shape.size()), shape.data());
  H5Pset_fletcher32(properties);  // damaged values are found when they are read
  const Handle dataset(file, H5Dcreate2(parent, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose,
                       std::string("cannot create ") + name);
  if (H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0)
    fail(file, std::string("cannot write ") + name + "; check the free space");
  write_text(file, dataset, "units", units);
  write_text(file, dataset, "frame", "field");
  write_text(file, dataset, "long_name", long_name);
}

/// HDF5 1.10 reads beyond its memory where a file without checksums on its structure is damaged. Superblocks have them from version 2 on,
/// and so do object headers, which then begin with "OHDR". Whatever is opened must have been through here.
class Checksums {
 public:
  explicit Checksums(const std::filesystem::path& file) : file_(file), in_(file, std::ios::binary) {
    std::array<unsigned char, 48> block{};
    in_.read(reinterpret_cast<char*>(block.data()), block.size());
    const std::array<unsigned char, 8> signature{0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
    if (!in_ || !std::equal(signature.begin(), signature.end(), block.begin())) fail(file, "is not an HDF5 file, or its start is damaged");
    const auto address = [&block](std::size_t at) {
      std::uint64_t value = 0;
      for (std::size_t i = 0; i < 8; ++i) value |= std::uint64_t{block[at + i]} << 8 * i;
      return value;
    };
    // Version; bytes per address and per length; base address; address of an extension, none; of the root.
    if (block[8] < 2 || block[9] != 8 || block[10] != 8 || address(12) != 0 || address(20) != HADDR_UNDEF) refuse("its superblock");
    require_at(address(36), "its root");
  }

  /// Of the object behind a link.
  void require_of(hid_t parent, const char* name, const std::string& what) {
    H5L_info_t link;
    if (H5Lget_info(parent, name, &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
      fail(file_, what + " is a link to another place; put the data here");
    require_at(link.u.address, what);
  }

 private:
  void require_at(std::uint64_t address, const std::string& what) {
    std::array<char, 4> word{};
    in_.seekg(static_cast<std::streamoff>(std::min<std::uint64_t>(address, std::numeric_limits<std::int64_t>::max())));
    in_.read(word.data(), word.size());
    if (!in_ || std::string_view(word.data(), word.size()) != "OHDR") refuse(what);
  }
  [[noreturn]] void refuse(const std::string& what) const {
    fail(file_,
         what +
             " is damaged, or of HDF5's oldest format, which has no checksums; write the file with write_field_hdf5 or, in Python, with "
             "h5py.File(…, libver='v110')");
  }

  const std::filesystem::path& file_;
  std::ifstream in_;
};

std::string to_text(const std::vector<hsize_t>& shape) {
  std::string text = "[";
  for (const hsize_t n : shape) {
    if (text.size() > 1) text += ", ";
    text += std::to_string(n);
  }
  return text + "]";
}

/// Reads a dataset of floating-point numbers after `accept` has seen its shape and returned where to put them.
void read_numbers(const std::filesystem::path& file, Checksums& checksums, hid_t parent, const char* name, const std::string& units,
                  const std::function<double*(const std::vector<hsize_t>&)>& accept) {
  const std::string what = std::string("dataset ") + name;
  if (H5Lexists(parent, name, H5P_DEFAULT) <= 0) fail(file, what + " is missing; write the file again with write_field_hdf5");
  checksums.require_of(parent, name, what);
  const Handle dataset(file, H5Dopen2(parent, name, H5P_DEFAULT), H5Dclose, what + " cannot be opened");
  const Handle type(file, H5Dget_type(dataset), H5Tclose, what + " has no type");
  if (H5Tget_class(type) != H5T_FLOAT) fail(file, what + " does not hold floating-point numbers");
  if (const std::string found = read_text(file, dataset, "units"); found != units)
    fail(file, what + " has units '" + found + "'; needed: '" + units + "'. Convert it");
  const Handle space(file, H5Dget_space(dataset), H5Sclose, what + " has no data space");
  std::vector<hsize_t> shape(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
  H5Sget_simple_extent_dims(space, shape.data(), nullptr);
  // Compression gains a factor of 1,100 at most: less on disk means that the shape is a lie, found before memory is asked for.
  double needed = static_cast<double>(H5Tget_size(type));
  for (const hsize_t n : shape) needed *= static_cast<double>(n);
  if (needed > 1100.0 * static_cast<double>(H5Dget_storage_size(dataset)))
    fail(file, what + " holds fewer values than its shape " + to_text(shape) + " promises");
  double* values = accept(shape);
  if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0)
    fail(file, what + " cannot be read; the file is damaged, restore it");
}

}  // namespace

GridField read_field_hdf5(const std::filesystem::path& file) {
  const Quiet quiet;
  if (!std::filesystem::is_regular_file(file)) fail(file, "no such file");
  Checksums checksums(file);
  // Whatever the library itself leaves open when it meets damage is closed with the file.
  const Handle access(file, H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "no properties");
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  const Handle root(file, H5Fopen(file.c_str(), H5F_ACC_RDONLY, access), H5Fclose, "is shorter than it says itself or damaged; restore it");
  if (const std::string found = read_text(file, root, "schema"); found != schema)
    fail(file, (found.empty() ? std::string("has no schema") : "holds '" + found + "'") + "; needed: '" + schema + "'");
  if (const std::string found = read_text(file, root, "schema_version"); !found.starts_with("1."))
    fail(file, "has schema version '" + found + "'; this library reads 1.x");
  Grid grid;
  const std::string outside = read_text(file, root, "outside");
  if (outside != "zero" && outside != "clamp") fail(file, "attribute outside is '" + outside + "'; needed: 'zero' or 'clamp'");
  grid.outside = outside == "zero" ? Outside::zero : Outside::clamp;
  for (const auto& [name, bound] : {std::pair{"lower", &grid.lower}, std::pair{"upper", &grid.upper}})
    read_numbers(file, checksums, root, name, "m", [&, n = name, b = bound](const std::vector<hsize_t>& shape) {
      if (shape != std::vector<hsize_t>{3}) fail(file, std::string("dataset ") + n + " has shape " + to_text(shape) + "; needed: [3]");
      return b->data();
    });
  read_numbers(file, checksums, root, "velocity", "m/s", [&](const std::vector<hsize_t>& shape) {
    double count = 1.0;
    for (const hsize_t n : shape) count *= static_cast<double>(n);
    if (shape.size() != 4 || shape[3] != 3 || count < 3.0 || count > 3.0 * most_points)
      fail(file, "dataset velocity has shape " + to_text(shape) + "; needed: [nz, ny, nx, 3] with 1 to 512^3 points");
    grid.points = {static_cast<int>(shape[2]), static_cast<int>(shape[1]), static_cast<int>(shape[0])};
    grid.values.resize(3, static_cast<Eigen::Index>(count / 3.0));
    return grid.values.data();
  });
  return checked(file, std::move(grid));
}

void write_field_hdf5(const std::filesystem::path& file, const GridField& field) {
  const Quiet quiet;
  const Grid& grid = field.grid();
  const std::filesystem::path partial = file.string() + ".partial";
  try {
    {
      // The format of HDF5 1.10 has checksums on its structure.
      const Handle access(partial, H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "no properties");
      H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
      const Handle root(partial, H5Fcreate(partial.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose,
                        "cannot be created; check that the folder exists and may be written to");
      write_text(partial, root, "schema", schema);
      write_text(partial, root, "schema_version", schema_version);
      write_text(partial, root, "outside", grid.outside == Outside::zero ? "zero" : "clamp");
      write_numbers(partial, root, "lower", {3}, grid.lower.data(), "m", "position of the first grid point");
      write_numbers(partial, root, "upper", {3}, grid.upper.data(), "m", "position of the last grid point");
      const Eigen::Array3<hsize_t> n = grid.points.cast<hsize_t>().array();
      write_numbers(partial, root, "velocity", {n[2], n[1], n[0], 3}, grid.values.data(), "m/s",
                    "wind velocity at the grid points, indices z, y, x, component");
      if (H5Fflush(root, H5F_SCOPE_GLOBAL) < 0) fail(partial, "cannot be written to the end; check the free space");
    }
    std::filesystem::rename(partial, file);
  } catch (const std::filesystem::filesystem_error& fault) {
    fail(file, std::string("cannot be put in its place: ") + fault.what());
  } catch (...) {
    std::error_code ignored;  // the first fault is the one to report
    std::filesystem::remove(partial, ignored);
    throw;
  }
}

}  // namespace dragcore
