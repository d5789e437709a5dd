#include "cfd_cases/campaign/slurm.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <optional>
#include <queue>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "cfd_cases/flow_case/solve.hpp"
#include "cfd_cases/programs/subprocess.hpp"

namespace cfd_cases {

namespace fs = std::filesystem;
using case_record::CaseRecord;
using Clock = std::chrono::steady_clock;
using namespace std::string_literals;

namespace {

/// By name, which begins with the time of submission.
std::vector<fs::path> submissions(const Cache& cache) {
  std::vector<fs::path> folders;
  if (fs::exists(cache.root / "slurm"))
    for (const auto& entry : fs::directory_iterator(cache.root / "slurm"))
      if (entry.path().extension().empty()) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  return folders;
}

/// Keys of a submission in the order of its array, whose first index is 1.
std::vector<std::string> keys_of(const fs::path& submission) {
  std::vector<std::string> keys;
  std::ifstream file(submission / "cases");
  for (std::string line; std::getline(file, line);) keys.push_back(line.substr(0, line.find(' ')));
  return keys;
}

/// What became of a job that Slurm forgot (MinJobAge after its end, five minutes by default), from slurmd's last word in its log.
std::string state_by_log(const fs::path& log) {
  std::string last, line;
  for (std::ifstream file(log); std::getline(file, line);)
    if (line.find("*** JOB ") != std::string::npos || line.find("oom") != std::string::npos) last = line;
  for (const auto& [words, state] : {std::pair{"DUE TO TIME LIMIT", "TIMEOUT"}, std::pair{"oom", "OUT_OF_MEMORY"},
                                     std::pair{"DUE TO NODE FAILURE", "NODE_FAIL"}, std::pair{"CANCELLED AT", "CANCELLED"}})
    if (last.find(words) != std::string::npos) return state;
  return "UNKNOWN";
}

std::string in_quotes(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

/// One job array.
struct Batch {
  SlurmLimits limits;
  std::vector<const PlannedCase*> cases;
  double cpu_s = 0.0;
  int slots = 0;                ///< 0: no throttle
  bool after_previous = false;  ///< waits for the end of the array before it
};

/// Cases by how many of them must be solved one after the other before: each starts from the fields of one in the layer below.
std::vector<std::vector<const PlannedCase*>> layers_of(const std::vector<const PlannedCase*>& cases) {
  std::vector<std::vector<const PlannedCase*>> layers;
  std::map<std::string, std::size_t> depth;  // a matrix names a case after the one that it starts from
  for (const PlannedCase* planned : cases) {
    const auto start = depth.find(planned->identity.start_key);
    const std::size_t at = depth[planned->identity.key] = start == depth.end() ? 0 : start->second + 1;
    if (layers.size() <= at) layers.resize(at + 1);
    layers[at].push_back(planned);
  }
  return layers;
}

/// Arrays by class of cost and no longer than Slurm allows, the largest last.
std::vector<Batch> batches_of(std::vector<const PlannedCase*> cases, const CampaignOptions& options, std::size_t longest) {
  // The longest case first, so that the last ones to end are short.
  std::stable_sort(cases.begin(), cases.end(), [](const auto* a, const auto* b) { return a->predicted_cpu_s > b->predicted_cpu_s; });
  std::map<SlurmLimits, std::vector<const PlannedCase*>> classes;
  for (const PlannedCase* planned : cases) classes[slurm_limits(*planned, options.ranks)].push_back(planned);
  std::vector<Batch> batches;
  for (const auto& [limits, members] : classes)
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (i % longest == 0) batches.push_back({.limits = limits, .cases = {}});
      batches.back().cases.push_back(members[i]);
      batches.back().cpu_s += members[i]->predicted_cpu_s;
    }
  std::stable_sort(batches.begin(), batches.end(), [](const Batch& a, const Batch& b) { return a.cpu_s < b.cpu_s; });
  if (options.jobs == 0) return batches;
  // The throttle of Slurm is one of an array. Each gets its part in proportion to its cost, so that all end at about the same time; where
  // there are too few slots for one each, the arrays run one after the other.
  const bool in_turn = static_cast<std::size_t>(options.jobs) < batches.size();
  int slots = options.jobs;
  double cpu_s = 0.0;
  for (const Batch& batch : batches) cpu_s += batch.cpu_s;
  for (Batch& batch : batches) {
    batch.slots = in_turn ? options.jobs : std::max(1, static_cast<int>(slots * batch.cpu_s / cpu_s + 1e-9));
    batch.after_previous = in_turn;
    slots -= batch.slots;
    cpu_s -= batch.cpu_s;
  }
  return batches;
}

/// The largest number of tasks in an array: the highest index must be below MaxArraySize.
std::size_t longest_array() {
  const std::string configuration = answer_of({"scontrol", "show", "config"}).text;
  const auto at = configuration.find("MaxArraySize");
  const int limit = at == std::string::npos ? 0 : std::atoi(configuration.c_str() + configuration.find('=', at) + 1);
  return static_cast<std::size_t>(std::max(2, limit ? limit : 1001) - 1);
}

/// Writes the folder of a job array and submits it. @param after  the jobs that must have ended. Returns its number.
std::string submit(const Batch& batch, const Cache& cache, const CampaignOptions& options, const SlurmOptions& slurm,
                   const std::set<std::string>& after) {
  for (const PlannedCase* planned : batch.cases)
    if (std::holds_alternative<dragcore::MeshBody>(planned->spec.shape))
      throw EnvironmentFault(fmt::format(
          "{} takes its body from a file, and jobs take nothing but the matrix along; run it with --executor local", planned->spec.name));
  std::random_device random;
  const std::string name = fmt::format("dragval-{:%Y%m%dT%H%M%S}-{:08x}", fmt::gmtime(std::time(nullptr)), random());
  const fs::path folder = fs::absolute(cache.root / "slurm" / name), unfinished = folder.string() + ".new";
  std::string list;
  for (const PlannedCase* planned : batch.cases) list += planned->identity.key + " " + planned->spec.name + "\n";
  std::string script = fmt::format(
      "#!/bin/sh\n"
      "#SBATCH --array=1-{}{}\n"
      "#SBATCH --requeue\n"
      "#SBATCH --open-mode=append\n"
      "#SBATCH --nodes=1\n"
      "#SBATCH --ntasks={}\n"
      "#SBATCH --mem={}M\n"
      "#SBATCH --time={}\n",
      batch.cases.size(), batch.slots ? fmt::format("%{}", batch.slots) : "", options.ranks, batch.limits.memory_mb, batch.limits.minutes);
  script += fmt::format(
      "# Task N solves the case in line N of the file `cases`: key and name.\n"
      "line=$(sed -n \"${{SLURM_ARRAY_TASK_ID}}p\" cases)\n"
      "{} run {} --only \"${{line#* }}\" --key \"${{line%% *}}\" --cache {} --ranks {}{}{}\n"
      "# 4: the case failed, and its record says why. For Slurm that is a job that did its work.\n"
      "code=$?\n"
      "[ $code -eq 4 ] || exit $code\n",
      in_quotes(fs::read_symlink("/proc/self/exe")), in_quotes(slurm.matrix.filename()), in_quotes(fs::absolute(cache.root)), options.ranks,
      options.retry_failed ? " --retry-failed" : "", options.keep ? " --keep" : "");
  write_files(unfinished, {{"cases", list}, {"script", script}});
  fs::copy_file(slurm.matrix, unfinished / slurm.matrix.filename());
  fs::rename(unfinished, folder);

  // Options on the command line win over those in the script, later ones over earlier ones: what jobs are known by stands last.
  std::vector<std::string> command{"sbatch"};
  command.insert(command.end(), slurm.sbatch_options.begin(), slurm.sbatch_options.end());
  if (!after.empty()) command.push_back(fmt::format("--dependency=afterany:{}", fmt::join(after, ":")));
  for (const std::string& word :
       {"--parsable"s, "--job-name=" + name, "--chdir=" + folder.string(), "--output=%a.log"s, (folder / "script").string()})
    command.push_back(word);
  const Answer answer = answer_of(command);
  if (answer.exit_code != 0) {
    fs::remove_all(folder);
    throw EnvironmentFault("sbatch refuses the jobs: " + answer.text);
  }
  // The last line is "17" or "17;cluster"; warnings may stand before it.
  std::istringstream lines(answer.text);
  std::string number;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) number = line.substr(0, line.find(';'));
  return number;
}

/// Follows cases until each has a record in the cache or an end in Slurm.
class Follower {
 public:
  Follower(std::vector<const PlannedCase*> open, const Tools& tools, const Cache& cache, const RunStore& store, CampaignResult& result)
      : open_(std::move(open)), tools_(tools), cache_(cache), store_(store), result_(result), total_(open_.size()) {}

  void follow(const std::atomic<bool>& cancel) {
    for (;;) {
      const std::size_t before = open_.size();
      look();
      if (open_.empty()) return;
      if (open_.size() != before) changed_ = Clock::now();
      // Squeue is a load on the controller of everybody: an answer comes late by a twentieth of the time waited for it, at most 30 s.
      const auto pause = std::clamp<Clock::duration>((Clock::now() - changed_) / 20, std::chrono::seconds(1), std::chrono::seconds(30));
      for (const auto end = Clock::now() + pause; Clock::now() < end; std::this_thread::sleep_for(std::chrono::milliseconds(100)))
        if (cancel) return interrupted();
    }
  }

 private:
  void look() {
    // First Slurm, then the cache: the record of a job that is over is there already.
    std::optional<std::map<std::string, SlurmTask>> tasks;
    try {
      tasks = slurm_tasks(cache_);
    } catch (const EnvironmentFault& fault) {
      say_once(fault.what());
    }
    std::set<std::string> stored;
    for (const auto& entry : fs::directory_iterator(cache_.root / "runs")) stored.insert(entry.path().stem());
    if (tasks) count(*tasks);
    std::erase_if(open_, [&](const PlannedCase* planned) {
      const std::string& key = planned->identity.key;
      if (stored.contains(key)) {
        const CaseRecord record = store_.read(cache_.run(key));
        // One that failed before and is tried again lies there from the beginning.
        if (!planned->cached || record.finished != planned->cached->finished) return end(*planned, record);
      }
      if (!tasks) return false;
      const auto found = tasks->find(key);
      return end_without_record(*planned, found == tasks->end() ? SlurmTask{.state = "UNKNOWN"} : found->second);
    });
    if (isatty(STDERR_FILENO)) std::fprintf(stderr, "\r\033[K[%zu/%zu] %s", done_, total_, left_.c_str());
  }

  void count(const std::map<std::string, SlurmTask>& tasks) {
    int running = 0, queued = 0;
    double cpu_s = 0.0;
    for (const PlannedCase* planned : open_) {
      const auto found = tasks.find(planned->identity.key);
      if (found == tasks.end()) continue;
      running += found->second.running();
      queued += found->second.queued();
      cpu_s += planned->predicted_cpu_s;
      // What everybody waits for now and then needs no word; the rest may need somebody to act.
      static const std::set<std::string> usual{"", "None", "Resources", "Priority", "JobArrayTaskLimit", "BeginTime", "Dependency"};
      if (found->second.queued() && !usual.contains(found->second.reason)) say_once(planned->spec.name + " is " + found->second.describe());
    }
    left_ = fmt::format("{} running, {} queued", running, queued);
    if (running > 0) left_ += ", " + time_left(cpu_s / running);
  }

  bool end(const PlannedCase& planned, const CaseRecord& record, bool stored = true) {
    double wall_s = 0.0;
    for (const auto& [stage, cost] : record.cost) wall_s += cost.wall_s;
    say(fmt::format("[{}/{}] {}; {}", ++done_, total_, outcome_line(record, wall_s), left_));
    result_.solved += stored;
    if (!case_record::is_usable(record.status)) result_.unusable.push_back(record);
    over_since_.erase(planned.identity.key);
    return true;
  }

  bool end_without_record(const PlannedCase& planned, const SlurmTask& task) {
    const std::string& key = planned.identity.key;
    if (task.queued() || task.running()) {
      over_since_.erase(key);
      return false;
    }
    // A job that ended by itself left a record; a network file system may show it, and its log, with delay.
    const bool certain = task.ended_by_slurm() || task.state == "CANCELLED";
    if (!certain && Clock::now() - over_since_.emplace(key, Clock::now()).first->second < std::chrono::seconds(60)) return false;
    const FileLock lock(cache_.lock(key));
    if (!lock.held()) return false;  // still at work, whatever Slurm thinks

    CaseRecord record = asked_record(planned.spec, planned.identity, tools_);
    record.status = task.state == "TIMEOUT" ? case_record::Status::timed_out : case_record::Status::failed;
    record.reason = task.describe();
    if (task.state == "TIMEOUT") record.reason += ": give it more with --sbatch-option=--time=MINUTES";
    if (task.state == "OUT_OF_MEMORY") record.reason += ": give it more with --sbatch-option=--mem=MEGABYTES";
    record.reason += fs::exists(task.log) ? "; log: " + log_excerpt(task.log)
                                          : "; it wrote no log: does the node see the folder " + task.log.parent_path().string() + "?";
    record.attempts.push_back({"slurm", record.status, record.reason});
    record.finished = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
    // What merely vanished, or was cancelled by somebody, says nothing of the case: it is told, and submitted again by the next run.
    if (task.ended_by_slurm()) store_.write(cache_.run(key), record);
    if (task.held()) answer_of({"scancel", task.job});
    return end(planned, record, task.ended_by_slurm());
  }

  void interrupted() {
    result_.interrupted = true;
    say(fmt::format("interrupted: {} cases go on in Slurm ({}). Run the same command to follow them; scancel --name=... ends them",
                    open_.size(), left_));
  }
  void say(const std::string& text) { std::fprintf(stderr, "%s%s\n", isatty(STDERR_FILENO) ? "\r\033[K" : "", text.c_str()); }
  void say_once(const std::string& text) {
    if (said_.insert(text).second) say(text);
  }

  std::vector<const PlannedCase*> open_;
  const Tools& tools_;
  const Cache& cache_;
  const RunStore& store_;
  CampaignResult& result_;
  std::size_t total_, done_ = 0;
  std::string left_;
  std::map<std::string, Clock::time_point> over_since_;
  std::set<std::string> said_;
  Clock::time_point changed_ = Clock::now();
};

}  // namespace

bool SlurmTask::held() const {
  // Slurm's words after SchedulerParameters=max_batch_requeue starts (five by default), of two ways to fail at a start.
  return state == "REQUEUE_HOLD" || state == "SPECIAL_EXIT" ||
         (state == "PENDING" && (reason == "JobHoldMaxRequeue" || reason == "launch failed requeued held"));
}
bool SlurmTask::queued() const { return state == "PENDING" && !held(); }
bool SlurmTask::running() const {
  static const std::set<std::string> words{"CONFIGURING", "RUNNING",   "COMPLETING", "SUSPENDED",   "STOPPED",      "REQUEUED",
                                           "RESIZING",    "SIGNALING", "STAGE_OUT",  "REQUEUE_FED", "RESV_DEL_HOLD"};
  return words.contains(state);
}
bool SlurmTask::ended_by_slurm() const {
  static const std::set<std::string> words{"BOOT_FAIL", "DEADLINE", "FAILED", "NODE_FAIL", "OUT_OF_MEMORY", "PREEMPTED", "TIMEOUT"};
  return words.contains(state) || held();
}
std::string SlurmTask::describe() const {
  const std::string number = job.empty() ? "" : ", job " + job;
  if (queued()) return fmt::format("queued in Slurm{} ({})", number, reason);
  if (running()) return fmt::format("running in Slurm{}", number);
  if (state == "UNKNOWN") return "forgotten by Slurm";
  return fmt::format("ended in Slurm{} ({})", number, held() ? reason : state);
}

std::map<std::string, SlurmTask> slurm_tasks(const Cache& cache) {
  std::map<std::string, SlurmTask> tasks;
  const auto folders = submissions(cache);
  if (folders.empty()) return tasks;
  std::string names;
  for (const fs::path& folder : folders) names += (names.empty() ? "" : ",") + folder.filename().string();
  const Answer answer = answer_of({"squeue", "--states=all", "--array", "--name=" + names, "--format=%j|%K|%T|%r|%i"});
  if (answer.exit_code != 0) throw EnvironmentFault("Slurm does not say what became of the jobs of this cache: " + answer.text);
  std::map<std::pair<std::string, std::string>, SlurmTask> known;  // by name and index, "N/A" for all that were cancelled before a start
  std::istringstream lines(answer.text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::string name, index, state, reason, job;
    for (std::string* field : {&name, &index, &state, &reason, &job}) std::getline(fields, *field, '|');
    known[{name, index}] = {.job_name = name, .job = job, .state = state, .reason = reason};
  }
  for (const fs::path& folder : folders) {
    int index = 0;
    for (const std::string& key : keys_of(folder)) {
      const std::string name = folder.filename();
      const fs::path log = folder / fmt::format("{}.log", ++index);
      auto found = known.find({name, std::to_string(index)});
      if (found == known.end()) found = known.find({name, "N/A"});
      tasks[key] = found != known.end() ? found->second : SlurmTask{.job_name = name, .state = state_by_log(log)};
      tasks[key].log = log;
    }
  }
  return tasks;
}

CampaignResult run_on_slurm(const std::vector<PlannedCase>& cases, const Tools& tools, const Cache& cache, const RunStore& store,
                            const CampaignOptions& options, const SlurmOptions& slurm, const std::atomic<bool>& cancel) {
  CampaignResult result;
  std::vector<const PlannedCase*> missing;
  for (const PlannedCase& planned : cases) {
    if (planned.to_solve(options.retry_failed)) {
      missing.push_back(&planned);
      continue;
    }
    ++result.cached;
    if (!case_record::is_usable(planned.cached->status)) result.unusable.push_back(*planned.cached);
  }
  if (missing.empty()) return result;
  if (const Check check = check_slurm(); !check.good)
    throw EnvironmentFault(fmt::format("--executor slurm cannot work here: {}. Fix: {}", check.found, check.fix));
  cache.make_folders();
  fs::create_directories(cache.root / "slurm");
  {
    // Of two drivers at the same time the second sees what the first submitted.
    FileLock lock(cache.lock("slurm"));
    while (!lock.try_again()) {
      if (cancel) {
        result.interrupted = true;
        return result;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    const auto tasks = slurm_tasks(cache);
    std::vector<const PlannedCase*> unknown;
    std::map<std::string, std::string> job_of;  // of cases that others may start from, by key
    for (const PlannedCase* planned : missing) {
      const auto found = tasks.find(planned->identity.key);
      const bool is_with_slurm = found != tasks.end() && (found->second.queued() || found->second.running());
      const bool has_a_verdict = found != tasks.end() && found->second.ended_by_slurm() && !options.retry_failed;
      if (is_with_slurm) job_of[planned->identity.key] = found->second.job;
      if (!is_with_slurm && !has_a_verdict) unknown.push_back(planned);
    }
    for (const auto& layer : layers_of(unknown)) {
      std::string job;
      for (const Batch& batch : batches_of(layer, options, longest_array())) {
        std::set<std::string> after;
        if (batch.after_previous && !job.empty()) after.insert(job);
        for (const PlannedCase* planned : batch.cases)
          if (const auto start = job_of.find(planned->identity.start_key); start != job_of.end()) after.insert(start->second);
        job = submit(batch, cache, options, slurm, after);
        for (const PlannedCase* planned : batch.cases) job_of[planned->identity.key] = job;
        std::fprintf(stderr, "job %s: %zu cases%s, %d MB and %d min each%s\n", job.c_str(), batch.cases.size(),
                     batch.slots ? fmt::format(", {} at a time", batch.slots).c_str() : "", batch.limits.memory_mb, batch.limits.minutes,
                     after.empty() ? "" : fmt::format(", after job {}", fmt::join(after, ", ")).c_str());
      }
    }
    if (unknown.size() < missing.size()) std::fprintf(stderr, "%zu cases are with Slurm already\n", missing.size() - unknown.size());
  }
  if (slurm.detach) {
    std::fprintf(stderr, "the same command without --detach follows them\n");
    return result;
  }
  Follower(missing, tools, cache, store, result).follow(cancel);
  std::sort(result.unusable.begin(), result.unusable.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return result;
}

SlurmLimits slurm_limits(const PlannedCase& planned, int ranks) {
  // Twice the prediction, which is an upper envelope of few measurements, and the libraries of each rank.
  const double memory_mb = 2e-6 * planned.predicted_memory_bytes + 200.0 * ranks;
  // Twenty times the prediction: a second rung of the retry ladder, iterations up to their limit, slower nodes.
  const double minutes = std::max(15.0, 20.0 * planned.predicted_cpu_s / 60.0);
  // Rounded up to powers of two, so that few classes hold all cases.
  const auto rounded = [](double value, double unit) { return static_cast<int>(unit * std::exp2(std::ceil(std::log2(value / unit)))); };
  return {rounded(memory_mb, 500.0), rounded(minutes, 15.0)};
}

double list_schedule_s(std::vector<double> seconds, int slots) {
  std::sort(seconds.begin(), seconds.end(), std::greater<>());
  std::priority_queue<double, std::vector<double>, std::greater<>> free_at;
  for (int i = 0; i < slots; ++i) free_at.push(0.0);
  double end = 0.0;
  for (const double duration : seconds) {
    const double done = free_at.top() + duration;
    free_at.pop();
    free_at.push(done);
    end = std::max(end, done);
  }
  return end;
}

Check check_slurm() {
  Check check{.name = "Slurm", .needed = false};
  for (const char* program : {"sbatch", "squeue", "scontrol", "scancel"})
    if (find_program(program).empty()) check.found += (check.found.empty() ? "not on PATH: " : ", ") + std::string(program);
  if (!check.found.empty()) {
    check.found += " (only --executor slurm needs it)";
    check.fix = "apt-get install slurm-client, with the cluster's /etc/slurm/slurm.conf and munge key; docs/cluster.md";
    return check;
  }
  const Answer ping = answer_of({"scontrol", "ping"});
  check.good = ping.exit_code == 0 && ping.text.find(" UP") != std::string::npos;
  check.found = ping.text.substr(0, ping.text.find_last_not_of(" \n") + 1);
  if (!check.good) {
    // Of all that scontrol says, the line that tells: its banners and its way there say nothing.
    std::istringstream lines(ping.text);
    for (std::string line; std::getline(lines, line);)
      if (line.find(" DOWN") != std::string::npos || line.find("fatal") != std::string::npos) check.found = line;
    check.fix =
        "this machine needs the cluster's /etc/slurm/slurm.conf (or SLURM_CONF) and a running slurmctld and munged; docs/cluster.md";
  }
  return check;
}

}  // namespace cfd_cases
