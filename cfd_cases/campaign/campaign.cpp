#include "cfd_cases/campaign/campaign.hpp"

#include <fmt/format.h>
#include <fnmatch.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "cfd_cases/flow_case/case_key.hpp"
#include "cfd_cases/flow_case/dictionaries.hpp"
#include "cfd_cases/flow_case/solve.hpp"
#include "cfd_cases/programs/subprocess.hpp"

namespace cfd_cases {

namespace fs = std::filesystem;
using case_record::CaseRecord;
using Clock = std::chrono::steady_clock;

namespace {

/// What the terminal shows. Called by all workers.
class Display {
 public:
  Display(std::size_t total, double predicted_cpu_s, int jobs) : total_(total), remaining_cpu_s_(predicted_cpu_s), jobs_(jobs) {}

  void update(const std::string& name, const Progress& progress) {
    const std::lock_guard guard(mutex_);
    running_[name] = progress;
    if (!terminal_ || Clock::now() - drawn_ < std::chrono::milliseconds(250)) return;
    drawn_ = Clock::now();
    std::string line = fmt::format("[{}/{}] {}", done_, total_, left());
    for (const auto& [running, at] : running_) {
      line += fmt::format(" | {} {}", running, at.stage);
      if (at.iteration > 0) line += fmt::format(" {} C_D {:.4f}", at.iteration, at.drag_coefficient);
    }
    std::fprintf(stderr, "\r\033[K%s", line.substr(0, 160).c_str());
  }
  void finish(const PlannedCase& planned, const CaseRecord& record, double wall_s) {
    const std::lock_guard guard(mutex_);
    running_.erase(planned.spec.name);
    ++done_;
    // Predictions are scaled by how the finished ones compare, so that a slow machine shows in the time left.
    remaining_cpu_s_ -= planned.predicted_cpu_s;
    spent_wall_s_ += wall_s;
    spent_predicted_s_ += planned.predicted_cpu_s;
    std::fprintf(stderr, "%s[%zu/%zu] %s; %s\n", terminal_ ? "\r\033[K" : "", done_, total_, outcome_line(record, wall_s).c_str(),
                 left().c_str());
  }
  void say(const std::string& text) {
    const std::lock_guard guard(mutex_);
    std::fprintf(stderr, "%s%s\n", terminal_ ? "\r\033[K" : "", text.c_str());
  }
  void drop(const std::string& name) {
    const std::lock_guard guard(mutex_);
    running_.erase(name);
  }

 private:
  std::string left() const {
    const double pace = spent_predicted_s_ > 0.0 ? spent_wall_s_ / spent_predicted_s_ : 1.0;
    return time_left(std::max(0.0, remaining_cpu_s_) * pace / jobs_);
  }

  const bool terminal_ = isatty(STDERR_FILENO) != 0;
  std::mutex mutex_;
  std::size_t total_, done_ = 0;
  double remaining_cpu_s_, spent_wall_s_ = 0.0, spent_predicted_s_ = 0.0;
  int jobs_;
  std::map<std::string, Progress> running_;
  Clock::time_point drawn_{};
};

}  // namespace

std::string outcome_line(const CaseRecord& record, double wall_s) {
  const double area = 0.5 * record.density * record.speed * record.speed * dragcore::properties(record.shape).reference_area;
  const std::string result =
      case_record::is_usable(record.status) ? fmt::format("C_D {:.4f}", record.load.force().x() / area) : record.reason;
  return fmt::format("{}: {}, {} ({} cells, {} iterations, {:.0f} s)", record.name, case_record::to_string(record.status), result,
                     record.cells, record.iterations, wall_s);
}

std::string time_left(double seconds) {
  return seconds < 1.0    ? "nothing left"
         : seconds < 90.0 ? fmt::format("{:.0f} s left", seconds)
                          : fmt::format("{:.0f} min left", seconds / 60.0);
}

bool named(const std::string& only, const std::string& case_name) {
  return only.empty() || fnmatch(only.c_str(), case_name.c_str(), 0) == 0 || case_name.find(only) != std::string::npos;
}

std::vector<PlannedCase> plan(const Matrix& matrix, const Tools& tools, const Cache& cache, const RunStore& store, const std::string& only,
                              const std::map<std::string, CaseRecord>& known) {
  const CostModel model = read_cost_model(cost_model_file());
  std::vector<PlannedCase> cases;
  for (const CaseSpec& spec : matrix.cases) {
    if (!named(only, spec.name)) continue;
    PlannedCase planned{.spec = spec, .identity = identify(spec, tools)};
    if (const fs::path run = cache.run(planned.identity.key); fs::exists(run))
      planned.cached = store.read(run);
    else if (const auto found = known.find(planned.identity.key); found != known.end())
      planned.cached = found->second;
    cases.push_back(std::move(planned));
  }
  // A case comes after the one that it starts from: backwards, whoever must be solved again for its fields asks for its own start, too.
  std::map<std::string, PlannedCase*> by_key;
  for (PlannedCase& planned : cases) by_key[planned.identity.key] = &planned;
  for (auto planned = cases.rbegin(); planned != cases.rend(); ++planned) {
    const std::string& start = planned->identity.start_key;
    const auto found = by_key.find(start);
    if (start.empty() || found == by_key.end()) continue;
    found->second->keep_fields = true;
    if (planned->to_solve(false) && !fs::exists(cache.fields(start))) found->second->fields_missing = true;
  }
  std::vector<const CaseRecord*> solved_here;
  for (const PlannedCase& planned : cases)
    if (planned.cached) solved_here.push_back(&*planned.cached);
  const Pace pace = pace_of(model, solved_here);
  std::set<std::string> meshes;
  for (PlannedCase& planned : cases) {
    planned.pace = pace;
    planned.estimate = model.estimate(planned.spec, planned.identity);
    const std::string& mesh = planned.identity.mesh_key;
    if (!planned.cached && (fs::exists(cache.mesh(mesh)) || !meshes.insert(mesh).second))
      planned.estimate.cpu_s["mesh"] = planned.estimate.cpu_s["convert"] = 0.0;
    planned.predicted_cpu_s = pace.factor * planned.estimate.total_cpu_s();
    planned.predicted_memory_bytes = planned.estimate.memory_bytes;
  }
  return cases;
}

PredictedSum predicted_sum(const std::vector<PlannedCase>& cases) {
  PredictedSum sum;
  double variance = 0.0;
  for (const PlannedCase& planned : cases) {
    if (planned.cached) continue;
    sum.cpu_s += planned.predicted_cpu_s;
    variance += std::pow(planned.estimate.relative_uncertainty * planned.predicted_cpu_s, 2);
  }
  if (!cases.empty()) variance += std::pow(cases.front().pace.relative_uncertainty() * sum.cpu_s, 2);
  sum.uncertainty = std::sqrt(variance);
  return sum;
}

CampaignResult run_campaign(const std::vector<PlannedCase>& cases, const Tools& tools, const Cache& cache, const RunStore& store,
                            const CampaignOptions& options, const std::atomic<bool>& cancel) {
  cache.make_folders();
  CampaignResult result;
  std::mutex mutex;  // guards result, queue, failure
  std::deque<const PlannedCase*> queue;
  std::set<std::string> open;  // keys of cases that are not done yet: what starts from them waits
  std::exception_ptr failure;
  double predicted = 0.0;
  for (const PlannedCase& planned : cases) {
    if (planned.to_solve(options.retry_failed)) {
      queue.push_back(&planned);
      open.insert(planned.identity.key);
      predicted += planned.predicted_cpu_s;
      continue;
    }
    ++result.cached;
    if (!case_record::is_usable(planned.cached->status)) result.unusable.push_back(*planned.cached);
  }
  // The longest first, so that the last ones to end are short.
  std::stable_sort(queue.begin(), queue.end(), [](const auto* a, const auto* b) { return a->predicted_cpu_s > b->predicted_cpu_s; });
  Display display(queue.size(), predicted, options.jobs);

  const auto solve = [&](const PlannedCase& planned) {
    const std::string& key = planned.identity.key;
    const FileLock lock(cache.lock(key));
    if (!lock.held()) return false;
    const fs::path target = cache.run(key);
    const auto began = Clock::now();
    // Another campaign may have solved it since the plan was made; a failed case that is to be tried again is still the one we know.
    std::optional<CaseRecord> record;
    if (fs::exists(target)) {
      record = store.read(target);
      const bool the_old_one = planned.cached && record->finished == planned.cached->finished;
      if (the_old_one || (planned.fields_missing && !fs::exists(cache.fields(key))) ||
          (options.retry_failed && !case_record::is_usable(record->status)))
        record.reset();
    }
    const bool solved_here = !record;
    if (solved_here) {
      record = solve_case(planned.spec, planned.identity, tools, cache, options.ranks, planned.keep_fields, cancel,
                          [&](const Progress& at) { display.update(planned.spec.name, at); });
      store.write(target, *record);
      if (case_record::is_usable(record->status) && !options.keep) fs::remove_all(cache.work(key));
    }
    display.finish(planned, *record, std::chrono::duration<double>(Clock::now() - began).count());
    const std::lock_guard guard(mutex);
    ++(solved_here ? result.solved : result.cached);
    if (!case_record::is_usable(record->status)) result.unusable.push_back(*record);
    return true;
  };
  const auto work = [&] {
    for (;;) {
      const PlannedCase* next = nullptr;
      {
        const std::lock_guard guard(mutex);
        if (cancel || failure || queue.empty()) return;
        const auto ready =
            std::find_if(queue.begin(), queue.end(), [&](const auto* planned) { return !open.contains(planned->identity.start_key); });
        if (ready != queue.end()) {
          next = *ready;
          queue.erase(ready);
        }
      }
      if (!next) {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        continue;
      }
      try {
        if (solve(*next)) {
          const std::lock_guard guard(mutex);
          open.erase(next->identity.key);
          continue;
        }
        // Held by another campaign: to the end of the queue. The pause keeps a queue of nothing else from spinning.
        display.update(next->spec.name, {"waits for another campaign"});
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        display.drop(next->spec.name);
        const std::lock_guard guard(mutex);
        queue.push_back(next);
      } catch (const Interrupted&) {
        return;
      } catch (...) {
        const std::lock_guard guard(mutex);
        if (!failure) failure = std::current_exception();
        return;
      }
    }
  };
  std::vector<std::thread> workers;
  for (int i = 0; i < std::min<int>(options.jobs, static_cast<int>(queue.size())); ++i) workers.emplace_back(work);
  for (auto& worker : workers) worker.join();
  if (failure) std::rethrow_exception(failure);
  result.interrupted = cancel;
  if (result.interrupted) display.say("interrupted: what was finished is stored, run the same command to go on");
  std::sort(result.unusable.begin(), result.unusable.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return result;
}

}  // namespace cfd_cases
