#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

/// The little of HDF5 that the stores need: tables of columns with units. Handles close themselves; every failure is a std::runtime_error.
namespace compare::hdf5 {

/// Debian's library is not safe for threads: whoever uses this namespace holds the lock.
std::mutex& library_mutex();

/// An open file, group or dataset.
class Handle {
 public:
  Handle(long long id, int (*close)(long long)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  long long id() const { return id_; }

 private:
  long long id_;
  int (*close_)(long long);
};

/// One row per case (or face, or patch), one column per component.
using Table = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// What a reader needs to know about a dataset; written as its attributes, empty ones left out.
struct Meaning {
  std::string units;  ///< "N", "deg", "1"
  std::string long_name;
  std::string frame;        ///< "wind", "body"
  std::string uncertainty;  ///< name of the dataset with the standard uncertainty of this one
};

enum class Number { real, integer };  ///< on disk: little-endian 64-bit floating point or integer

/// Writes a file under a temporary name, syncs it to the disk and renames it: at any moment `path` is whole or absent.
void write_file(const std::filesystem::path& path, const std::string& schema, const std::string& version,
                const std::function<void(const Handle&)>& contents);

/// Opens for reading and checks whose file it is. @throws std::runtime_error naming the file, what is wrong with it and what to do
Handle open_file(const std::filesystem::path& path, const std::string& schema, int major_version);

Handle create_group(const Handle& parent, const std::string& name);
Handle open_group(const Handle& parent, const std::string& name);
bool exists(const Handle& parent, const std::string& name);
std::vector<std::string> members(const Handle& group);

void write(const Handle& parent, const std::string& name, const Table& table, const Meaning& meaning, Number number = Number::real);
void write(const Handle& parent, const std::string& name, const std::vector<std::string>& words, const Meaning& meaning);
Table read_table(const Handle& parent, const std::string& name);
std::vector<std::string> read_words(const Handle& parent, const std::string& name);

/// Makes `scale` the dimension scale (row labels) of every other dataset of the group.
void label_rows(const Handle& group, const std::string& scale);

void write_attribute(const Handle& object, const std::string& name, const std::string& value);
std::string read_attribute(const Handle& object, const std::string& name);  ///< empty when there is none

}  // namespace compare::hdf5
