#pragma once

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

/// What the readers and writers of HDF5 files share: messages that name the file, checksums, and no file that is written half.
namespace dragcore::hdf5 {

struct File {
  std::string kind;  ///< "wind field", for messages
  std::filesystem::path path;
};

[[noreturn]] inline void fail(const File& file, const std::string& fault) {
  throw std::runtime_error(file.kind + " file " + file.path.string() + ": " + fault);
}

template <class Number>
hid_t native_type() {
  return std::is_same_v<Number, float> ? H5T_NATIVE_FLOAT : H5T_NATIVE_DOUBLE;
}

/// An HDF5 identifier that closes itself; the call that made it is named when it failed.
class Handle {
 public:
  Handle(const File& file, hid_t id, herr_t (*close)(hid_t), const std::string& fault) : id_(id), close_(close) {
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

inline void write_text(const File& file, hid_t object, const char* name, const std::string& text) {
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
inline std::string read_text(const File& file, hid_t object, const char* name) {
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

/// Of the type that `values` have.
template <class Number>
void write_numbers(const File& file, hid_t parent, const char* name, const std::vector<hsize_t>& shape, const Number* values,
                   const char* units, const char* frame, const char* long_name) {
  const Handle space(file, H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose, "no data space");
  const Handle properties(file, H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "no properties");
  H5Pset_obj_track_times(properties, false);  // same contents, same bytes
  H5Pset_chunk(properties, static_cast<int>(shape.size()), shape.data());
  H5Pset_fletcher32(properties);  // damaged values are found when they are read
  const Handle dataset(file,
                       H5Dcreate2(parent, name, std::is_same_v<Number, float> ? H5T_IEEE_F32LE : H5T_IEEE_F64LE, space, H5P_DEFAULT,
                                  properties, H5P_DEFAULT),
                       H5Dclose, std::string("cannot create ") + name);
  if (H5Dwrite(dataset, native_type<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0)
    fail(file, std::string("cannot write ") + name + "; check the free space");
  write_text(file, dataset, "units", units);
  write_text(file, dataset, "frame", frame);
  write_text(file, dataset, "long_name", long_name);
}

/// HDF5 1.10 reads beyond its memory where a file without checksums on its structure is damaged. Superblocks have them from version 2 on,
/// and so do object headers, which then begin with "OHDR". Whatever is opened must have been through here.
class Checksums {
 public:
  explicit Checksums(const File& file) : file_(file), in_(file.path, std::ios::binary) {
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
    fail(file_, what +
                    " is damaged, or of HDF5's oldest format, which has no checksums; write the file with this library or, in Python, with "
                    "h5py.File(…, libver='v110')");
  }

  const File& file_;
  std::ifstream in_;
};

inline std::string to_text(const std::vector<hsize_t>& shape) {
  std::string text = "[";
  for (const hsize_t n : shape) {
    if (text.size() > 1) text += ", ";
    text += std::to_string(n);
  }
  return text + "]";
}

/// Reads a dataset of floating-point numbers after `accept` has seen its shape and returned where to put them.
template <class Number>
void read_numbers(const File& file, Checksums& checksums, hid_t parent, const char* name, const std::string& units,
                  const std::function<Number*(const std::vector<hsize_t>&)>& accept) {
  const std::string what = std::string("dataset ") + name;
  if (H5Lexists(parent, name, H5P_DEFAULT) <= 0) fail(file, what + " is missing; write the file again");
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
  Number* values = accept(shape);
  if (H5Dread(dataset, native_type<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0)
    fail(file, what + " cannot be read; the file is damaged, restore it");
}

/// An open file of a schema, version 1.x, and what reading from it needs.
class Reader {
 public:
  Reader(const File& file, const std::string& schema)
      : file_(file),
        checksums_((std::filesystem::is_regular_file(file.path) ? void() : fail(file, "no such file"), file)),
        access_(file, H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "no properties"),
        root_(file, opened(file, access_), H5Fclose, "is shorter than it says itself or damaged; restore it") {
    if (const std::string found = text("schema"); found != schema)
      fail(file, (found.empty() ? std::string("has no schema") : "holds '" + found + "'") + "; needed: '" + schema + "'");
    if (const std::string found = text("schema_version"); !found.starts_with("1."))
      fail(file, "has schema version '" + found + "'; this library reads 1.x");
  }

  /// An attribute of the root; empty where there is none.
  std::string text(const char* name) const { return read_text(file_, root_, name); }

  template <class Number>
  void numbers(const char* name, const std::string& units, const std::function<Number*(const std::vector<hsize_t>&)>& accept) {
    read_numbers<Number>(file_, checksums_, root_, name, units, accept);
  }

 private:
  static hid_t opened(const File& file, hid_t access) {
    // Whatever the library itself leaves open when it meets damage is closed with the file.
    H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
    return H5Fopen(file.path.c_str(), H5F_ACC_RDONLY, access);
  }

  const Quiet quiet_;
  const File& file_;
  Checksums checksums_;
  const Handle access_, root_;
};

/// Makes a file of this schema, version 1.0, under a temporary name beside it, and renames it when `contents(file, root)` has written.
inline void write(const File& file, const std::string& schema, const std::function<void(const File&, hid_t)>& contents) {
  const Quiet quiet;
  const File partial{file.kind, file.path.string() + ".partial"};
  try {
    {
      // The format of HDF5 1.10 has checksums on its structure.
      const Handle access(partial, H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "no properties");
      H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
      const Handle root(partial, H5Fcreate(partial.path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose,
                        "cannot be created; check that the folder exists and may be written to");
      write_text(partial, root, "schema", schema);
      write_text(partial, root, "schema_version", "1.0");
      contents(partial, root);
      if (H5Fflush(root, H5F_SCOPE_GLOBAL) < 0) fail(partial, "cannot be written to the end; check the free space");
    }
    std::filesystem::rename(partial.path, file.path);
  } catch (const std::filesystem::filesystem_error& fault) {
    fail(file, std::string("cannot be put in its place: ") + fault.what());
  } catch (...) {
    std::error_code ignored;  // the first fault is the one to report
    std::filesystem::remove(partial.path, ignored);
    throw;
  }
}

}  // namespace dragcore::hdf5
