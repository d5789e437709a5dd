#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace cfd_cases {

/// A program to run, with its output in a file.
struct Command {
  std::vector<std::string> argv;
  std::filesystem::path folder = ".";
  std::filesystem::path log;  ///< stdout and stderr, appended
  double timeout_s = std::numeric_limits<double>::infinity();
  std::map<std::string, std::string> environment;  ///< added to the own one
};

struct Outcome {
  int exit_code = 0;  ///< 128 + signal when a signal ended it; 127 when it could not be started
  bool timed_out = false;
  bool cancelled = false;
  double cpu_s = 0.0;  ///< user and system time, of its children too
  double wall_s = 0.0;
};

/// Runs a program in a process group of its own, so that an interrupt at the terminal does not reach it and ending it ends all it started.
/// It dies when the calling thread does, kill -9 included. After the time-out, and when `cancel` becomes true, the group gets SIGTERM
/// and three seconds later SIGKILL.
/// @param poll  called about five times a second while the program runs
/// @throws std::runtime_error when the log cannot be written or the process not be made
Outcome run_command(const Command& command, const std::atomic<bool>& cancel, const std::function<void()>& poll = {});

/// What a short program said, on stdout and stderr.
struct Answer {
  int exit_code = 0;  ///< as in Outcome
  std::string text;
};
Answer answer_of(const std::vector<std::string>& argv, const std::map<std::string, std::string>& environment = {});

/// Its text alone, empty when it fails.
std::string output_of(const std::vector<std::string>& argv, const std::map<std::string, std::string>& environment);

/// Path of a program on PATH, empty when there is none.
std::filesystem::path find_program(const std::string& name);

/// An exclusive lock on a file, given back by the destructor or by the death of the process.
class FileLock {
 public:
  /// Takes the lock if nobody holds it. @throws std::runtime_error when the file cannot be made, or its file system has no locks
  explicit FileLock(const std::filesystem::path& path);
  ~FileLock();
  FileLock(FileLock&& other) noexcept : descriptor_(other.descriptor_), held_(other.held_) { other.descriptor_ = -1; }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  FileLock& operator=(FileLock&&) = delete;
  bool try_again();  ///< true when the lock is held now
  bool held() const { return held_; }

 private:
  int descriptor_ = -1;
  bool held_ = false;
};

}  // namespace cfd_cases
