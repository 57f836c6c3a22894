#include "batch/batch_jobs.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "batch/batch_key.h"
#include "vir/results/results_folder.h"

namespace vir::app {
namespace {

std::vector<std::string> setArguments(const Assignments& set) {
  std::vector<std::string> arguments;
  for (const auto& [key, value] : set) {
    arguments.push_back("--set");
    arguments.push_back(key + "=" + value);
  }
  return arguments;
}

}  // namespace

BatchJobs::BatchJobs(const BatchPlan& plan, const BatchRunOptions& options)
    : plan_(plan),
      options_(options),
      recordings_(recordingsOf(plan)),
      simulator_key_(simulatorKey(options.plugin_dir)),
      program_key_(programKey(options.plugin_dir)) {}

bool BatchJobs::isOurs(std::size_t i, const Shard& shard) const {
  return i % shard.count == shard.index - 1;
}

std::string BatchJobs::rawlogOf(const BatchRecording& r) const {
  if (!r.sequence->rawlog.empty()) return r.sequence->rawlog;
  return options_.out + "/recordings/" + r.name() + ".rawlog";
}

BatchJob BatchJobs::simulation(std::size_t i) const {
  const BatchRecording& r = recordings_[i];
  BatchJob job;
  job.recording = i;
  job.name = r.name();
  const std::string stem = options_.out + "/recordings/" + r.name();
  job.marker = stem + ".done.json";
  job.log = stem + ".log";
  Assignments set = r.sequence->set;
  set.insert(set.end(), r.condition->set.begin(), r.condition->set.end());
  set.emplace_back("simulator.seed", std::to_string(r.seed));
  const std::vector<std::string> arguments = setArguments(set);
  job.key = keyOf(simulator_key_, {r.sequence->world}, arguments);
  job.arguments = {"simulate", r.sequence->world, "--out", rawlogOf(r)};
  complete(&job, arguments);
  return job;
}

std::vector<BatchJob> BatchJobs::runs(std::size_t i) const {
  const BatchRecording& r = recordings_[i];
  const std::string key = r.condition == nullptr
                              ? keyOf("", {}, {rawlogOf(r), sizeText(rawlogOf(r))})
                              : simulation(i).key;
  std::vector<BatchJob> out;
  for (const BatchSetting& setting : plan_.settings) {
    BatchJob job = runOf(i, setting, key);
    if (job.name.find(options_.only) != std::string::npos) out.push_back(std::move(job));
  }
  return out;
}

BatchJob BatchJobs::runOf(std::size_t i, const BatchSetting& setting,
                          const std::string& recording_key) const {
  const BatchRecording& r = recordings_[i];
  BatchJob job;
  job.recording = i;
  job.setting = &setting;
  job.name = r.name() + "/" + setting.name;
  const std::string folder = batchRunFolder(options_.out, r, setting);
  job.marker = folder + "/batch.json";
  job.log = folder + "/batch.log";
  job.arguments = {"run", setting.ini, "--rawlog", rawlogOf(r), "--out", folder};
  const std::vector<std::string> arguments = setArguments(setting.set);
  job.key = keyOf(program_key_ + recording_key, {setting.ini}, arguments);
  complete(&job, arguments);
  return job;
}

void BatchJobs::complete(BatchJob* job, const std::vector<std::string>& arguments) const {
  job->arguments.insert(job->arguments.end(), arguments.begin(), arguments.end());
  if (options_.plugin_dir.empty()) return;
  job->arguments.insert(job->arguments.end(), {"--plugin-dir", options_.plugin_dir});
}

bool BatchJobs::isDone(const BatchJob& job) {
  std::ifstream in(job.marker);
  if (!in) return false;
  const auto json = nlohmann::json::parse(in, nullptr, false);
  return json.is_object() && json.value("key", "") == job.key && json.value("ok", false);
}

void BatchJobs::mark(const BatchJob& job, const ChildExit& exit, double seconds) {
  nlohmann::ordered_json json;
  json["key"] = job.key;
  json["ok"] = exit.ok;
  if (!exit.ok) json["problem"] = exit.problem;
  json["seconds"] = seconds;
  // Complete or not there at all, even if this process is killed.
  results::writeTextFile(job.marker, json.dump(2) + "\n");
}

}  // namespace vir::app
