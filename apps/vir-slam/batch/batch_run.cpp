#include "batch/batch_run.h"

#include <chrono>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "batch/batch_key.h"
#include "batch/child_process.h"
#include "commands/commands.h"
#include "output/console.h"
#include "vir/results/results_folder.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

/// One process to come: simulate a recording, or run a setting on one.
struct Job {
  std::size_t recording = 0;
  const BatchSetting* setting = nullptr;  ///< null: simulate
  std::string name, marker, log, key;
  std::vector<std::string> arguments;
};

std::vector<std::string> setArguments(const Assignments& set) {
  std::vector<std::string> arguments;
  for (const auto& [key, value] : set) {
    arguments.push_back("--set");
    arguments.push_back(key + "=" + value);
  }
  return arguments;
}

/// True if the marker says that the job with this key ended well.
bool isDone(const Job& job) {
  std::ifstream in(job.marker);
  if (!in) return false;
  const auto json = nlohmann::json::parse(in, nullptr, false);
  return json.is_object() && json.value("key", "") == job.key && json.value("ok", false);
}

void mark(const Job& job, const ChildExit& exit, double seconds) {
  nlohmann::ordered_json json;
  json["key"] = job.key;
  json["ok"] = exit.ok;
  if (!exit.ok) json["problem"] = exit.problem;
  json["seconds"] = seconds;
  // Complete or not there at all, even if this process is killed.
  results::writeTextFile(job.marker, json.dump(2) + "\n");
}

class BatchRunner {
 public:
  BatchRunner(const BatchPlan& plan, const BatchRunOptions& options)
      : plan_(plan),
        options_(options),
        recordings_(recordingsOf(plan)),
        key_base_(programKey(options.plugin_dir)),
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
    Job job;
    std::unique_ptr<ChildProcess> process;
  };

  std::string rawlogOf(const BatchRecording& r) const {
    if (!r.sequence->rawlog.empty()) return r.sequence->rawlog;
    return options_.out + "/recordings/" + r.name() + ".rawlog";
  }

  Job simulationOf(std::size_t i) const {
    const BatchRecording& r = recordings_[i];
    Job job;
    job.recording = i;
    job.name = r.name();
    const std::string stem = options_.out + "/recordings/" + r.name();
    job.marker = stem + ".done.json";
    job.log = stem + ".log";
    Assignments set = r.sequence->set;
    set.insert(set.end(), r.condition->set.begin(), r.condition->set.end());
    set.emplace_back("simulator.seed", std::to_string(r.seed));
    const std::vector<std::string> arguments = setArguments(set);
    job.key = keyOf(key_base_, {r.sequence->world}, arguments);
    job.arguments = {"simulate", r.sequence->world, "--out", rawlogOf(r)};
    complete(&job, arguments);
    return job;
  }

  Job runOf(std::size_t i, const BatchSetting& setting, const std::string& recording_key) const {
    const BatchRecording& r = recordings_[i];
    Job job;
    job.recording = i;
    job.setting = &setting;
    job.name = r.name() + "/" + setting.name;
    const std::string folder = batchRunFolder(options_.out, r, setting);
    job.marker = folder + "/batch.json";
    job.log = folder + "/batch.log";
    job.arguments = {"run", setting.ini, "--rawlog", rawlogOf(r), "--out", folder};
    const std::vector<std::string> arguments = setArguments(setting.set);
    job.key = keyOf(recording_key, {setting.ini}, arguments);
    complete(&job, arguments);
    return job;
  }

  void complete(Job* job, const std::vector<std::string>& arguments) const {
    job->arguments.insert(job->arguments.end(), arguments.begin(), arguments.end());
    if (options_.plugin_dir.empty()) return;
    job->arguments.insert(job->arguments.end(), {"--plugin-dir", options_.plugin_dir});
  }

  /// What is left to do of one recording and its runs.
  void queueRecording(std::size_t i) {
    const BatchRecording& r = recordings_[i];
    if (i % options_.shard.count != options_.shard.index - 1) return;
    const bool real = r.condition == nullptr;
    const Job simulation = real ? Job() : simulationOf(i);
    const std::string key =
        real ? keyOf(key_base_, {}, {rawlogOf(r), sizeText(rawlogOf(r))}) : simulation.key;
    std::deque<Job> runs;
    for (const BatchSetting& setting : plan_.settings) {
      Job job = runOf(i, setting, key);
      if (!options_.only.empty() && job.name.find(options_.only) == std::string::npos) continue;
      if (!options_.fresh && isDone(job)) {
        ++counts_.found_done;
      } else {
        runs.push_back(std::move(job));
      }
    }
    if (runs.empty()) return;
    open_runs_[i] = runs.size();
    if (real || (!options_.fresh && isDone(simulation) && fs::exists(rawlogOf(r)))) {
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
      Job job = std::move(pending_.front());
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
    const Job& job = ended.job;
    const ChildExit& exit = ended.process->exit();
    mark(job, exit, ended.process->seconds());
    report(job, exit, ended.process->seconds());
    if (job.setting == nullptr) {
      std::deque<Job> runs = std::move(waiting_[job.recording]);
      waiting_.erase(job.recording);
      if (exit.ok) {
        // Before further recordings, so that those of a full disk can be removed soon.
        pending_.insert(pending_.begin(), runs.begin(), runs.end());
      } else {
        counts_.failed += runs.size();
        for (const Job& run : runs) {
          fs::create_directories(fs::path(run.marker).parent_path());
          mark(run, {false, "no recording: " + exit.problem}, 0);
        }
      }
      return;
    }
    exit.ok ? ++counts_.done : ++counts_.failed;
    if (--open_runs_[job.recording] == 0 && !plan_.keep_recordings) removeRecording(job.recording);
  }

  void report(const Job& job, const ChildExit& exit, double seconds) {
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
    for (const char* end : {".rawlog", "_Images", ".ini", "_anchors_truth.csv", ".done.json"}) {
      fs::remove_all(stem + end);
    }
  }

  const BatchPlan& plan_;
  const BatchRunOptions& options_;
  const std::vector<BatchRecording> recordings_;
  const std::string key_base_, program_;
  std::deque<Job> pending_;
  std::map<std::size_t, std::deque<Job>> waiting_;  // runs whose recording is not there yet
  std::map<std::size_t, std::size_t> open_runs_;    // by recording
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
