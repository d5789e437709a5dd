#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "cfd_cases/programs/subprocess.hpp"
#include "tests/cfd_cases/temporary_folder.hpp"

using namespace cfd_cases;

namespace {

const std::atomic<bool> kNever = false;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Waits up to five seconds for a process to be gone; zombies count as gone.
bool gone(pid_t pid) {
  for (int i = 0; i < 100; ++i) {
    if (kill(pid, 0) != 0 || text_of("/proc/" + std::to_string(pid) + "/stat").find(") Z") != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

}  // namespace

TEST_CASE("a program's exit code, output, folder and environment are its own", "[cfd_cases][subprocess]") {
  const TemporaryFolder folder;
  const auto log = folder.path / "log";
  const Outcome outcome = run_command({.argv = {"sh", "-c", "echo \"$GREETING in $(pwd)\"; exit 3"},
                                       .folder = folder.path,
                                       .log = log,
                                       .environment = {{"GREETING", "hello"}}},
                                      kNever);
  CHECK(outcome.exit_code == 3);
  CHECK(text_of(log) == "hello in " + std::filesystem::canonical(folder.path).string() + "\n");
  CHECK_FALSE(outcome.timed_out);
  CHECK(run_command({.argv = {"no-such-program-at-all"}, .log = log}, kNever).exit_code == 127);
  CHECK(run_command({.argv = {"sh", "-c", "kill -FPE $$"}, .log = log}, kNever).exit_code == 128 + SIGFPE);
}

TEST_CASE("a time-out ends the program's children, too", "[cfd_cases][subprocess][hard]") {
  const TemporaryFolder folder;
  const auto log = folder.path / "log";
  // The shell starts a grandchild, tells its number, and waits.
  const Outcome outcome = run_command({.argv = {"sh", "-c", "sleep 300 & echo $!; wait"}, .log = log, .timeout_s = 0.5}, kNever);
  CHECK(outcome.timed_out);
  CHECK(outcome.exit_code == 128 + SIGTERM);
  CHECK(outcome.wall_s < 4.0);  // 0.5 s and at most the 3 s of grace
  const pid_t grandchild = std::stoi(text_of(log));
  CHECK(gone(grandchild));
}

TEST_CASE("a program deaf to SIGTERM is killed after its three seconds of grace", "[cfd_cases][subprocess][hard]") {
  const TemporaryFolder folder;
  const Outcome outcome = run_command(
      {.argv = {"sh", "-c", "trap '' TERM; while true; do sleep 0.1; done"}, .log = folder.path / "log", .timeout_s = 0.2}, kNever);
  CHECK(outcome.timed_out);
  CHECK(outcome.exit_code == 128 + SIGKILL);
}

TEST_CASE("cancelling from another thread ends a program at once", "[cfd_cases][subprocess]") {
  const TemporaryFolder folder;
  std::atomic<bool> cancel = false;
  std::thread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    cancel = true;
  });
  const Outcome outcome = run_command({.argv = {"sleep", "300"}, .log = folder.path / "log"}, cancel);
  canceller.join();
  CHECK(outcome.cancelled);
  CHECK(outcome.wall_s < 3.0);
}

TEST_CASE("processor time counts children and not sleep", "[cfd_cases][subprocess]") {
  const TemporaryFolder folder;
  // The loop runs in a child of the shell; 200,000 rounds take at least some hundredths of a second on any machine.
  const Outcome busy = run_command(
      {.argv = {"sh", "-c", "(i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done); exit 0"}, .log = folder.path / "log"}, kNever);
  const Outcome idle = run_command({.argv = {"sleep", "0.5"}, .log = folder.path / "log"}, kNever);
  CHECK(busy.cpu_s > 0.02);
  CHECK(idle.cpu_s < 0.1);
  CHECK(idle.wall_s >= 0.5);
}

TEST_CASE("only one holder has a lock, and the next one gets it when it is given back", "[cfd_cases][subprocess]") {
  const TemporaryFolder folder;
  auto first = std::make_unique<FileLock>(folder.path / "lock");
  FileLock second(folder.path / "lock");
  CHECK(first->held());
  CHECK_FALSE(second.held());
  CHECK_FALSE(second.try_again());
  first.reset();
  CHECK(second.try_again());
}
