#include "batch/slurm_engine.h"

#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "batch/batch_jobs.h"
#include "batch/child_process.h"
#include "output/console.h"
#include "vir/results/results_folder.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

constexpr int kAttempts = 3;
constexpr std::chrono::milliseconds kLookEvery{1000};
constexpr int kUnansweredLooks = 60;  // the scheduler may be away for a while

std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

struct Answer {
  int code = 0;
  std::string text;  ///< what it printed, errors included
};

Answer ask(const std::string& command) {
  FILE* pipe = popen(("(" + command + ") 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot start a shell for " + command);
  Answer answer;
  char buffer[1024];
  for (std::size_t n = 0; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) {
    answer.text.append(buffer, n);
  }
  const int status = pclose(pipe);
  answer.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  while (!answer.text.empty() && answer.text.back() == '\n') answer.text.pop_back();
  return answer;
}

class SlurmEngine {
 public:
  SlurmEngine(const BatchPlan& plan, const BatchRunOptions& options, const SlurmJob& job)
      : options_(options), job_(job), jobs_(plan, options) {
    const std::size_t recordings = jobs_.recordings().size();
    const auto wanted = static_cast<std::size_t>(std::max(0, job.tasks));
    parts_ = std::max<std::size_t>(1, wanted == 0 ? recordings : std::min(wanted, recordings));
    for (std::size_t i = 0; i < recordings; ++i) {
      for (BatchJob& run : jobs_.runs(i)) runs_.emplace_back(i, std::move(run));
    }
  }

  BatchCounts run() {
    BatchCounts counts;
    const std::size_t before = options_.fresh ? 0 : doneRuns();
    counts.found_done = before;
    if (before > 0) std::printf("%zu of %zu were done before\n", before, runs_.size());
    for (int attempt = 1; attempt <= kAttempts && !counts.interrupted; ++attempt) {
      const std::set<std::size_t> open = openParts(attempt == 1 && options_.fresh);
      if (open.empty()) break;
      submit(open, attempt == 1);
      counts.interrupted = !wait();
    }
    bar_.clear();
    const std::size_t done = doneRuns();
    counts.done = done > before ? done - before : 0;
    counts.failed = counts.interrupted ? 0 : runs_.size() - done;
    return counts;
  }

 private:
  std::size_t doneRuns() const {
    return static_cast<std::size_t>(std::count_if(
        runs_.begin(), runs_.end(), [](const auto& run) { return BatchJobs::isDone(run.second); }));
  }

  /// Parts, from 1, with a run that is not done.
  std::set<std::size_t> openParts(bool all) const {
    std::set<std::size_t> out;
    for (const auto& [recording, run] : runs_) {
      if (all || !BatchJobs::isDone(run)) out.insert(recording % parts_ + 1);
    }
    return out;
  }

  /// Where tasks write what they say, and the script.
  std::string folder() const { return fs::absolute(options_.out).string() + "/slurm"; }

  std::string script(bool first) const {
    std::string words = quoted(ownProgram()) + " batch " + quoted(job_.ini) + " --out " +
                        quoted(fs::absolute(options_.out).string()) +
                        " --jobs \"${SLURM_CPUS_PER_TASK:-1}\" --shard \"$SLURM_ARRAY_TASK_ID/" +
                        std::to_string(parts_) + "\"";
    for (const std::string& set : job_.set) words += " --set " + quoted(set);
    if (!options_.only.empty()) words += " --only " + quoted(options_.only);
    if (!options_.plugin_dir.empty()) {
      words += " --plugin-dir " + quoted(fs::absolute(options_.plugin_dir).string());
    }
    if (options_.fresh && first) words += " --fresh";
    return "#!/bin/sh\nexec " + words + "\n";
  }

  void submit(const std::set<std::size_t>& open, bool first) {
    fs::create_directories(folder());
    const std::string file = folder() + "/task.sh";
    results::writeTextFile(file, script(first));
    std::string array;
    for (const std::size_t part : open) array += (array.empty() ? "" : ",") + std::to_string(part);
    const Answer answer = ask("sbatch --parsable --job-name=vir-slam --array=" + array +
                              " --output=" + quoted(folder() + "/%A_%a.log") + " " + job_.options +
                              " " + quoted(file));
    if (answer.code == 127) {
      throw std::runtime_error(
          "sbatch is not here: --engine slurm needs a machine that submits to Slurm");
    }
    if (answer.code != 0) throw std::runtime_error("sbatch: " + answer.text);
    // Warnings come before the number, a cluster's name behind it.
    const std::string last = answer.text.substr(answer.text.rfind('\n') + 1);
    id_ = last.substr(0, last.find(';'));
    if (id_.empty() || id_.find_first_not_of("0123456789") != std::string::npos) {
      throw std::runtime_error("sbatch gave no number of a job: " + answer.text);
    }
    std::printf("job %s of Slurm: %zu tasks, logs in %s\n", id_.c_str(), open.size(),
                folder().c_str());
    std::fflush(stdout);
  }

  /// False if it was interrupted; the job is taken back then.
  bool wait() {
    int unanswered = 0;
    while (true) {
      if (interrupted()) {
        bar_.clear();
        ask("scancel " + id_);
        std::printf("job %s was taken back\n", id_.c_str());
        return false;
      }
      const Answer answer = ask("squeue --noheader --array --format=%T --job " + id_);
      // A job that is over for some minutes is not known any more.
      const bool forgotten = answer.text.find("Invalid job id") != std::string::npos;
      if (answer.code != 0 && !forgotten) {
        if (++unanswered > kUnansweredLooks) throw std::runtime_error("squeue: " + answer.text);
      } else {
        unanswered = 0;
        if (forgotten || answer.text.empty()) return true;
        tell(answer.text);
      }
      std::this_thread::sleep_for(kLookEvery);
    }
  }

  /// How far it is, and what the scheduler says of the tasks when that changes.
  void tell(const std::string& states) {
    std::map<std::string, int> count;
    std::istringstream in(states);
    for (std::string state; in >> state;) ++count[state];
    std::string line;
    for (const auto& [state, n] : count) {
      line += (line.empty() ? "" : ", ") + std::to_string(n) + " " + state;
    }
    if (line != told_) {
      bar_.clear();
      std::printf("tasks: %s\n", line.c_str());
      std::fflush(stdout);
    }
    told_ = line;
    if (!runs_.empty()) {
      bar_.show(static_cast<double>(doneRuns()) / static_cast<double>(runs_.size()));
    }
  }

  const BatchRunOptions& options_;
  const SlurmJob& job_;
  const BatchJobs jobs_;
  std::size_t parts_ = 1;
  std::vector<std::pair<std::size_t, BatchJob>> runs_;  // with their recordings
  std::string id_, told_;
  ProgressBar bar_;
};

}  // namespace

BatchCounts runOnSlurm(const BatchPlan& plan, const BatchRunOptions& options, const SlurmJob& job) {
  return SlurmEngine(plan, options, job).run();
}

}  // namespace vir::app
