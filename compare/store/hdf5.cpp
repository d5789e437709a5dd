#include "compare/store/hdf5.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace compare::hdf5 {
namespace {

/// Takes over what an H5 call returned, or says which call failed.
Handle owned(hid_t id, herr_t (*close)(hid_t), const std::string& what) {
  if (id < 0) throw std::runtime_error("HDF5 could not " + what);
  return {id, reinterpret_cast<int (*)(long long)>(close)};
}
static_assert(sizeof(hid_t) == sizeof(long long), "Handle keeps HDF5 identifiers as long long");

void check(herr_t result, const std::string& what) {
  if (result < 0) throw std::runtime_error("HDF5 could not " + what);
}

/// The library prints its own error stack on stderr unless told not to; our messages name file and remedy instead.
void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

Handle fixed_text(std::size_t length) {
  Handle type = owned(H5Tcopy(H5T_C_S1), H5Tclose, "copy a text type");
  check(H5Tset_size(type.id(), std::max<std::size_t>(length, 1)), "set a text length");
  check(H5Tset_cset(type.id(), H5T_CSET_UTF8), "set UTF-8");
  check(H5Tset_strpad(type.id(), H5T_STR_NULLPAD), "set text padding");
  return type;
}

/// Same contents, same bytes: no times. One chunk, compressed.
Handle creation_properties(const std::vector<hsize_t>& dims) {
  Handle properties = owned(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "create properties");
  check(H5Pset_obj_track_times(properties.id(), false), "switch off time stamps");
  const hsize_t entries = dims[0] * (dims.size() > 1 ? dims[1] : 1);
  if (entries >= 64) {  // below, a chunk index costs more than compression gains
    check(H5Pset_chunk(properties.id(), static_cast<int>(dims.size()), dims.data()), "set a chunk size");
    check(H5Pset_shuffle(properties.id()), "set the shuffle filter");
    check(H5Pset_deflate(properties.id(), 6), "set gzip");
  }
  return properties;
}

void write_dataset(const Handle& parent, const std::string& name, const std::vector<hsize_t>& dims, hid_t file_type, hid_t memory_type,
                   const void* values, const Meaning& meaning) {
  if (dims[0] == 0) throw std::invalid_argument("dataset " + name + " would have no rows; write at least one");
  const Handle space = owned(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose, "create a data space");
  const Handle properties = creation_properties(dims);
  const Handle dataset = owned(H5Dcreate2(parent.id(), name.c_str(), file_type, space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT),
                               H5Dclose, "create dataset " + name);
  check(H5Dwrite(dataset.id(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "write dataset " + name);
  for (const auto& [key, text] : {std::pair{"units", meaning.units}, std::pair{"long_name", meaning.long_name},
                                  std::pair{"frame", meaning.frame}, std::pair{"uncertainty", meaning.uncertainty}})
    if (!text.empty()) write_attribute(dataset, key, text);
}

std::vector<hsize_t> dimensions(const Handle& dataset) {
  const Handle space = owned(H5Dget_space(dataset.id()), H5Sclose, "read a data space");
  std::vector<hsize_t> dims(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space.id()))));
  H5Sget_simple_extent_dims(space.id(), dims.data(), nullptr);
  return dims;
}

void sync_to_disk(const std::filesystem::path& path, int flags) {
  const int descriptor = ::open(path.c_str(), flags);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  const int error = errno;
  if (descriptor >= 0) ::close(descriptor);
  if (!synced) throw std::runtime_error(fmt::format("could not sync {} to disk: {}", path.string(), std::strerror(error)));
}

}  // namespace

std::mutex& library_mutex() {
  static std::mutex mutex;
  return mutex;
}

void write_file(const std::filesystem::path& path, const std::string& schema, const std::string& version,
                const std::function<void(const Handle&)>& contents) {
  silence();
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  // The process id keeps two writers apart; a leftover of a killed one has no .h5 at its end, so nobody reads it.
  const std::filesystem::path partial = path.string() + ".partial-" + std::to_string(::getpid());
  try {
    {
      const Handle properties = owned(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "create properties");
      check(H5Pset_obj_track_times(properties.id(), false), "switch off time stamps");
      const Handle file = owned(H5Fcreate(partial.c_str(), H5F_ACC_TRUNC, properties.id(), H5P_DEFAULT), H5Fclose,
                                "create " + partial.string() + "; check that the folder exists, may be written to and has space");
      write_attribute(file, "schema", schema);
      write_attribute(file, "schema_version", version);
      contents(file);
      check(H5Fflush(file.id(), H5F_SCOPE_GLOBAL), "flush " + partial.string());
    }
    sync_to_disk(partial, O_RDONLY);
    std::filesystem::rename(partial, path);
    sync_to_disk(folder, O_RDONLY | O_DIRECTORY);
  } catch (...) {
    std::error_code ignored;  // the first error is the one to report
    std::filesystem::remove(partial, ignored);
    throw;
  }
}

Handle open_file(const std::filesystem::path& path, const std::string& schema, int major_version) {
  silence();
  const std::string name = path.string();
  const std::string remedy = "; restore it from version control, or delete it and run again";
  if (!std::filesystem::exists(path)) throw std::runtime_error(name + " does not exist; `dragval run` and `dragval collect` make it");
  if (H5Fis_hdf5(path.c_str()) <= 0) throw std::runtime_error(name + " is not an HDF5 file (or its start is damaged)" + remedy);
  const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (id < 0) throw std::runtime_error(name + " is damaged: it is shorter than it says itself, or may not be read" + remedy);
  Handle file = owned(id, H5Fclose, "open " + name);
  const std::string found = read_attribute(file, "schema");
  if (found != schema)
    throw std::runtime_error(fmt::format("{} holds {}, not '{}'; give the path of a file that dragval wrote", name,
                                         found.empty() ? "no schema of this program" : "'" + found + "'", schema));
  const std::string version = read_attribute(file, "schema_version");
  if (const int major = std::atoi(version.c_str()); major != major_version)
    throw std::runtime_error(fmt::format("{} has schema version {}, this program reads {}.x; {}", name, version, major_version,
                                         major > major_version ? "use a newer dragval" : "collect it again with this dragval"));
  return file;
}

Handle create_group(const Handle& parent, const std::string& name) {
  const Handle properties = owned(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, "create properties");
  check(H5Pset_obj_track_times(properties.id(), false), "switch off time stamps");
  return owned(H5Gcreate2(parent.id(), name.c_str(), H5P_DEFAULT, properties.id(), H5P_DEFAULT), H5Gclose, "create group " + name);
}

Handle open_group(const Handle& parent, const std::string& name) {
  return owned(H5Gopen2(parent.id(), name.c_str(), H5P_DEFAULT), H5Gclose, "open group " + name);
}

bool exists(const Handle& parent, const std::string& name) { return H5Lexists(parent.id(), name.c_str(), H5P_DEFAULT) > 0; }

std::vector<std::string> members(const Handle& group) {
  std::vector<std::string> names;
  const auto append = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  check(H5Literate(group.id(), H5_INDEX_NAME, H5_ITER_INC, nullptr, append, &names), "list a group");
  return names;
}

void write(const Handle& parent, const std::string& name, const Table& table, const Meaning& meaning, Number number) {
  std::vector<hsize_t> dims = {static_cast<hsize_t>(table.rows())};
  if (table.cols() > 1) dims.push_back(static_cast<hsize_t>(table.cols()));
  write_dataset(parent, name, dims, number == Number::real ? H5T_IEEE_F64LE : H5T_STD_I64LE, H5T_NATIVE_DOUBLE, table.data(), meaning);
}

void write(const Handle& parent, const std::string& name, const std::vector<std::string>& words, const Meaning& meaning) {
  std::size_t width = 1;
  for (const std::string& word : words) width = std::max(width, word.size());
  std::string block(width * words.size(), '\0');
  for (std::size_t i = 0; i < words.size(); ++i) words[i].copy(block.data() + i * width, width);
  const Handle type = fixed_text(width);
  write_dataset(parent, name, {words.size()}, type.id(), type.id(), block.data(), meaning);
}

Table read_table(const Handle& parent, const std::string& name) {
  const Handle dataset = owned(H5Dopen2(parent.id(), name.c_str(), H5P_DEFAULT), H5Dclose, "find dataset " + name);
  const std::vector<hsize_t> dims = dimensions(dataset);
  if (dims.empty() || dims.size() > 2) throw std::runtime_error("dataset " + name + " is not a table of one or two dimensions");
  Table table(static_cast<Eigen::Index>(dims[0]), dims.size() > 1 ? static_cast<Eigen::Index>(dims[1]) : 1);
  check(H5Dread(dataset.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, table.data()), "read dataset " + name);
  return table;
}

std::vector<std::string> read_words(const Handle& parent, const std::string& name) {
  const Handle dataset = owned(H5Dopen2(parent.id(), name.c_str(), H5P_DEFAULT), H5Dclose, "find dataset " + name);
  const Handle stored = owned(H5Dget_type(dataset.id()), H5Tclose, "read a type");
  const std::vector<hsize_t> dims = dimensions(dataset);
  if (H5Tget_class(stored.id()) != H5T_STRING || H5Tis_variable_str(stored.id()) > 0 || dims.size() != 1)
    throw std::runtime_error("dataset " + name + " is not a list of texts of fixed length");
  const std::size_t width = H5Tget_size(stored.id());
  std::string block(width * dims[0], '\0');
  const Handle type = fixed_text(width);
  check(H5Dread(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, block.data()), "read dataset " + name);
  std::vector<std::string> words(dims[0]);
  for (std::size_t i = 0; i < words.size(); ++i) words[i].assign(block.data() + i * width, ::strnlen(block.data() + i * width, width));
  return words;
}

void label_rows(const Handle& group, const std::string& scale) {
  const auto open = [&](const std::string& name) {
    return owned(H5Dopen2(group.id(), name.c_str(), H5P_DEFAULT), H5Dclose, "open dataset " + name);
  };
  const Handle labels = open(scale);
  check(H5DSset_scale(labels.id(), scale.c_str()), "make " + scale + " a dimension scale");
  for (const std::string& name : members(group)) {
    H5O_info_t info;
    check(H5Oget_info_by_name(group.id(), name.c_str(), &info, H5P_DEFAULT), "inspect " + name);
    if (info.type == H5O_TYPE_DATASET && name != scale)
      check(H5DSattach_scale(open(name).id(), labels.id(), 0), "label the rows of " + name);
  }
}

void write_attribute(const Handle& object, const std::string& name, const std::string& value) {
  const Handle type = fixed_text(value.size());
  const Handle space = owned(H5Screate(H5S_SCALAR), H5Sclose, "create a data space");
  const Handle attribute =
      owned(H5Acreate2(object.id(), name.c_str(), type.id(), space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose, "create attribute " + name);
  check(H5Awrite(attribute.id(), type.id(), value.c_str()), "write attribute " + name);
}

std::string read_attribute(const Handle& object, const std::string& name) {
  if (H5Aexists(object.id(), name.c_str()) <= 0) return "";
  const Handle attribute = owned(H5Aopen(object.id(), name.c_str(), H5P_DEFAULT), H5Aclose, "open attribute " + name);
  const Handle stored = owned(H5Aget_type(attribute.id()), H5Tclose, "read a type");
  if (H5Tget_class(stored.id()) != H5T_STRING || H5Tis_variable_str(stored.id()) > 0) return "";
  std::string value(H5Tget_size(stored.id()), '\0');
  const Handle type = fixed_text(value.size());
  check(H5Aread(attribute.id(), type.id(), value.data()), "read attribute " + name);
  value.resize(::strnlen(value.data(), value.size()));
  return value;
}

}  // namespace compare::hdf5
