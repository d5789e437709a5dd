#include "cfd_cases/programs/subprocess.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <thread>

extern char** environ;

namespace cfd_cases {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

namespace {

int exit_code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::vector<std::string> environment_with(const std::map<std::string, std::string>& added) {
  std::vector<std::string> all;
  for (char** entry = environ; *entry; ++entry) {
    const std::string line = *entry;
    if (!added.contains(line.substr(0, line.find('=')))) all.push_back(line);
  }
  for (const auto& [name, value] : added) all.push_back(name + "=" + value);
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& lines) {
  std::vector<char*> all;
  for (auto& line : lines) all.push_back(line.data());
  all.push_back(nullptr);
  return all;
}

/// Starts the program with its output in `output`. Everything is prepared before fork(): between it and execve() a child of a process with
/// threads may only make system calls.
pid_t start(const Command& command, int output) {
  const std::string folder = fs::absolute(command.folder).string();
  std::map<std::string, std::string> added = command.environment;
  added["PWD"] = folder;  // OpenFOAM believes it, and warns when it is not the working folder
  std::vector<std::string> argv = command.argv, environment = environment_with(added);
  std::string program = find_program(argv.at(0)).string();
  if (program.empty()) program = argv[0];
  const std::vector<char*> arguments = pointers(argv), variables = pointers(environment);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error(fmt::format("cannot start {}: {}", command.argv[0], std::strerror(errno)));
  if (child == 0) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(127);  // the parent died before prctl()
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    const int silence = open("/dev/null", O_RDONLY);
    if (silence < 0 || dup2(silence, 0) < 0 || dup2(output, 1) < 0 || dup2(output, 2) < 0 || chdir(folder.c_str()) != 0) _exit(127);
    execve(program.c_str(), arguments.data(), variables.data());
    _exit(127);
  }
  setpgid(child, child);  // also here: whoever is first
  return child;
}

}  // namespace

Outcome run_command(const Command& command, const std::atomic<bool>& cancel, const std::function<void()>& poll) {
  const int log = open(command.log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log < 0) throw std::runtime_error(fmt::format("cannot write {}: {}", command.log.string(), std::strerror(errno)));
  const auto began = Clock::now();
  pid_t child = -1;
  try {
    child = start(command, log);
  } catch (...) {
    close(log);
    throw;
  }
  close(log);

  Outcome outcome;
  rusage usage{};
  int status = 0;
  auto polled = began, asked_to_stop = began;
  auto pause = milliseconds(1);
  while (wait4(child, &status, WNOHANG, &usage) == 0) {
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, milliseconds(20));
    if (poll && Clock::now() - polled > milliseconds(200)) {
      poll();
      polled = Clock::now();
    }
    if (!outcome.timed_out && !outcome.cancelled) {
      outcome.cancelled = cancel.load();
      outcome.timed_out = !outcome.cancelled && seconds_since(began) > command.timeout_s;
      if (outcome.cancelled || outcome.timed_out) {
        kill(-child, SIGTERM);
        asked_to_stop = Clock::now();
      }
    } else if (Clock::now() - asked_to_stop > milliseconds(3000)) {
      kill(-child, SIGKILL);
    }
  }
  kill(-child, SIGKILL);  // whatever it left behind in its group; ESRCH when there is nothing
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  outcome.exit_code = exit_code_of(status);
  outcome.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  outcome.wall_s = seconds_since(began);
  return outcome;
}

Answer answer_of(const std::vector<std::string>& argv, const std::map<std::string, std::string>& environment) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return {127, {}};
  const pid_t child = start({.argv = argv, .folder = ".", .log = {}, .environment = environment}, ends[1]);
  close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  return {exit_code_of(status), text};
}

std::string output_of(const std::vector<std::string>& argv, const std::map<std::string, std::string>& environment) {
  Answer answer = answer_of(argv, environment);
  return answer.exit_code == 0 ? std::move(answer.text) : std::string();
}

fs::path find_program(const std::string& name) {
  if (name.find('/') != std::string::npos) return access(name.c_str(), X_OK) == 0 ? fs::path(name) : fs::path();
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const fs::path candidate = fs::path(folder) / name; access(candidate.c_str(), X_OK) == 0) return candidate;
  return {};
}

FileLock::FileLock(const fs::path& path) : descriptor_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
  if (descriptor_ < 0) throw std::runtime_error(fmt::format("cannot make the lock {}: {}", path.string(), std::strerror(errno)));
  try {
    try_again();
  } catch (...) {
    close(descriptor_);
    throw;
  }
}
FileLock::~FileLock() {
  if (descriptor_ >= 0) close(descriptor_);
}
bool FileLock::try_again() {
  if (!held_ && flock(descriptor_, LOCK_EX | LOCK_NB) == 0) held_ = true;
  // Some network file systems have no locks: waiting for one would never end.
  if (!held_ && errno != EWOULDBLOCK && errno != EINTR)
    throw std::runtime_error(
        fmt::format("the file system of the cache refuses locks (flock: {}); choose another with --cache", std::strerror(errno)));
  return held_;
}

}  // namespace cfd_cases
