#include <catch2/catch.hpp>

#include "cfd_cases/campaign/slurm.hpp"
#include "tests/cfd_cases/temporary_folder.hpp"

using namespace cfd_cases;

TEST_CASE("a list schedule gives each job to the slot that is free first", "[cfd_cases][slurm][analytic]") {
  CHECK(list_schedule_s({}, 3) == 0.0);
  CHECK(list_schedule_s({1, 2, 3}, 1) == 6.0);
  CHECK(list_schedule_s({1, 2, 3}, 5) == 3.0);
  // Longest first: 5 | 4, then 3 behind the 4 that ends before the 5, and 2 behind the 5.
  CHECK(list_schedule_s({3, 2, 5, 4}, 2) == 7.0);
}

TEST_CASE("what a job asks for grows with its cost, in few classes", "[cfd_cases][slurm]") {
  const auto limits = [](double memory_bytes, double cpu_s, int ranks = 1) {
    PlannedCase planned;
    planned.predicted_cpu_s = cpu_s;
    planned.predicted_memory_bytes = memory_bytes;
    return slurm_limits(planned, ranks);
  };
  CHECK(limits(1e8, 1.0) == limits(1e8, 40.0));  // the floor of a quarter of an hour
  CHECK(limits(1e8, 50.0).minutes == 30);        // 20 times 50 s are 17 min
  CHECK(limits(1e8, 3600.0).minutes >= 20 * 60);
  CHECK(limits(8e8, 1.0).memory_mb > limits(1e8, 1.0).memory_mb);
  CHECK(limits(1e8, 1.0, 16).memory_mb > limits(1e8, 1.0).memory_mb);
}

TEST_CASE("a job that Slurm gave up is over, one that was cancelled is nobody's fault", "[cfd_cases][slurm]") {
  const auto task = [](const char* state, const char* reason) { return SlurmTask{.state = state, .reason = reason}; };
  CHECK(task("PENDING", "Resources").queued());
  CHECK(task("COMPLETING", "None").running());
  CHECK_FALSE(task("PENDING", "JobHoldMaxRequeue").queued());
  CHECK(task("PENDING", "JobHoldMaxRequeue").ended_by_slurm());
  for (const char* state : {"TIMEOUT", "OUT_OF_MEMORY", "NODE_FAIL", "FAILED"}) CHECK(task(state, "None").ended_by_slurm());
  for (const char* state : {"CANCELLED", "COMPLETED", "UNKNOWN"}) CHECK_FALSE(task(state, "None").ended_by_slurm());
}

TEST_CASE("a cache that never saw Slurm has no tasks, and needs no Slurm to say so", "[cfd_cases][slurm]") {
  const TemporaryFolder folder;
  CHECK(slurm_tasks({folder.path}).empty());
}
