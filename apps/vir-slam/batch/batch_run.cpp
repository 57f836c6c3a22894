#include "batch/batch_run.h"

#include <chrono>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <thread>

#include "batch/batch_jobs.h"
#include "batch/child_process.h"
#include "commands/commands.h"
#include "output/console.h"
#include "vir/results/results_folder.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

class BatchRunner {
 public:
  BatchRunner(const BatchPlan& plan, const BatchRunOptions& options)
      : plan_(plan),
        options_(options),
        jobs_(plan, options),
        recordings_(jobs_.recordings()),
        program_(ownProgram()) {}

  BatchCounts run() {
    for (std::size_t i = 0; i < recordings_.size(); ++i) queueRecording(i);
    total_ = counts_.found_done + pending_.size() + waitingRuns();
    if (counts_.found_done > 0) {
      std::printf("%zu of %zu were done before\n", counts_.found_done, total_);
    }
    while (!pending_.empty() || !active_.empty()) {
      startJobs();
      collect();
      if (interrupted()) {
        counts_.interrupted = true;
        active_.clear();  // kills them
        break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    bar_.clear();
    return counts_;
  }

 private:
  struct Active {
    BatchJob job;
    std::unique_ptr<ChildProcess> process;
  };

  /// What is left to do of one recording and its runs.
  void queueRecording(std::size_t i) {
    const BatchRecording& r = recordings_[i];
    if (!jobs_.isOurs(i, options_.shard)) return;
    const bool real = r.condition == nullptr;
    std::deque<BatchJob> runs;
    for (BatchJob& job : jobs_.runs(i)) {
      if (!options_.fresh && BatchJobs::isDone(job)) {
        ++counts_.found_done;
      } else {
        runs.push_back(std::move(job));
      }
    }
    if (runs.empty()) return;
    open_runs_[i] = runs.size();
    if (real) {
      pending_.insert(pending_.end(), runs.begin(), runs.end());
      return;
    }
    const BatchJob simulation = jobs_.simulation(i);
    if (!options_.fresh && BatchJobs::isDone(simulation) && fs::exists(jobs_.rawlogOf(r))) {
      pending_.insert(pending_.end(), runs.begin(), runs.end());
    } else {
      waiting_[i] = std::move(runs);
      pending_.push_back(simulation);
    }
  }

  std::size_t waitingRuns() const {
    std::size_t n = 0;
    for (const auto& [recording, runs] : waiting_) n += runs.size();
    return n;
  }

  void startJobs() {
    while (active_.size() < static_cast<std::size_t>(options_.jobs) && !pending_.empty()) {
      BatchJob job = std::move(pending_.front());
      pending_.pop_front();
      fs::create_directories(fs::path(job.log).parent_path());
      fs::remove(job.marker);
      auto process = std::make_unique<ChildProcess>(program_, job.arguments, job.log);
      active_.push_back({std::move(job), std::move(process)});
    }
  }

  void collect() {
    for (auto it = active_.begin(); it != active_.end();) {
      if (it->process->seconds() > plan_.timeout_s) {
        it->process->kill("took longer than " + fixed(plan_.timeout_s, 0) + " s");
      }
      if (!it->process->finished()) {
        ++it;
        continue;
      }
      const Active ended = std::move(*it);
      it = active_.erase(it);
      finish(ended);
    }
    if (total_ > 0) {
      const std::size_t finished = counts_.done + counts_.failed + counts_.found_done;
      bar_.show(static_cast<double>(finished) / static_cast<double>(total_));
    }
  }

  void finish(const Active& ended) {
    const BatchJob& job = ended.job;
    const ChildExit& exit = ended.process->exit();
    BatchJobs::mark(job, exit, ended.process->seconds());
    report(job, exit, ended.process->seconds());
    if (job.setting == nullptr) {
      std::deque<BatchJob> runs = std::move(waiting_[job.recording]);
      waiting_.erase(job.recording);
      if (exit.ok) {
        // Before further recordings, so that those of a full disk can be removed soon.
        pending_.insert(pending_.begin(), runs.begin(), runs.end());
      } else {
        counts_.failed += runs.size();
        for (const BatchJob& run : runs) {
          fs::create_directories(fs::path(run.marker).parent_path());
          BatchJobs::mark(run, {false, "no recording: " + exit.problem}, 0);
        }
      }
      return;
    }
    exit.ok ? ++counts_.done : ++counts_.failed;
    if (--open_runs_[job.recording] == 0 && !plan_.keep_recordings) removeRecording(job.recording);
  }

  void report(const BatchJob& job, const ChildExit& exit, double seconds) {
    bar_.clear();
    if (exit.ok) {
      std::printf("%-40s %7.1f s\n", job.name.c_str(), seconds);
    } else {
      std::printf("%-40s failed: %s; see %s\n", job.name.c_str(), exit.problem.c_str(),
                  job.log.c_str());
    }
    std::fflush(stdout);
  }

  void removeRecording(std::size_t i) const {
    const BatchRecording& r = recordings_[i];
    if (r.condition == nullptr) return;  // not ours
    const std::string stem = options_.out + "/recordings/" + r.name();
    for (const char* end :
         {".rawlog", "_Images", ".ini", "_anchors_truth.csv", "_anchors.csv", ".done.json"}) {
      fs::remove_all(stem + end);
    }
  }

  const BatchPlan& plan_;
  const BatchRunOptions& options_;
  const BatchJobs jobs_;
  const std::vector<BatchRecording>& recordings_;
  const std::string program_;
  std::deque<BatchJob> pending_;
  std::map<std::size_t, std::deque<BatchJob>> waiting_;  // runs whose recording is not there yet
  std::map<std::size_t, std::size_t> open_runs_;         // by recording
  std::vector<Active> active_;
  std::size_t total_ = 0;
  BatchCounts counts_;
  ProgressBar bar_;
};

}  // namespace

std::string batchRunFolder(const std::string& out, const BatchRecording& recording,
                           const BatchSetting& setting) {
  return out + "/runs/" + recording.name() + "/" + setting.name;
}

std::vector<std::string> batchWork(const BatchPlan& plan, const BatchRunOptions& options) {
  std::vector<std::string> names;
  const std::vector<BatchRecording> recordings = recordingsOf(plan);
  for (std::size_t i = options.shard.index - 1; i < recordings.size(); i += options.shard.count) {
    for (const BatchSetting& setting : plan.settings) {
      const std::string name = recordings[i].name() + "/" + setting.name;
      if (name.find(options.only) != std::string::npos) names.push_back(name);
    }
  }
  return names;
}

BatchCounts runBatch(const BatchPlan& plan, const BatchRunOptions& options) {
  fs::create_directories(options.out + "/recordings");
  const results::OutputLock lock(options.out + "/part_" + std::to_string(options.shard.index) +
                                 "_of_" + std::to_string(options.shard.count));
  return BatchRunner(plan, options).run();
}

}  // namespace vir::app
