/// Runs the estimator on simulated flights over many seeds and says how good it was. See --help.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <future>
#include <iostream>
#include <sstream>

#include "simulated_run.h"
#include "vir/core/settings.h"
#include "vir/evaluation/figure.h"
#include "vir/simulation/flights.h"

using namespace vir;
using namespace vir::tool;

namespace {

struct Arguments {
  std::string trajectory, seeds = "1", csv, plot, camera, ranges = "off", tum, errors = "usual";
  double start_s = 0, duration_s = 0, nlos = -1, bias = 0;
  int jobs = 1;
  bool log = false;
  std::vector<std::string> set, anchors, outages, blackouts;
};

const char* const kExamples =
    "simulate_runs --trajectory MH_03_medium.tum --seeds 1..5\n"
    "simulate_runs --trajectory corridor --set Flight.length_m=150 --seeds 1..20 --csv errors.csv\n"
    "simulate_runs --trajectory V1_02_medium.tum --ranges on --anchor 3,0,1 --nlos 0.1\n\n"
    "Runs the estimator on simulated tracks and IMU readings (and ranges); prints errors per seed "
    "and their mean.\n";

void parse(int argc, char** argv, CLI::App* app, Arguments* a) {
  app->add_option("--trajectory", a->trajectory,
                  "TUM file, or a flight: eight, corridor, route ...")
      ->required();
  app->add_option("--seeds", a->seeds, "one seed, or FIRST..LAST");
  app->add_option("--start", a->start_s, "leave out this much of the file [s]");
  app->add_option("--duration", a->duration_s, "fly this much of the file [s]");
  app->add_option("--camera", a->camera, "forward | euroc: calibration and mounting");
  app->add_option("--errors", a->errors, "kind | usual | harsh: defaults that --set changes")
      ->check(CLI::IsMember({"kind", "usual", "harsh"}));
  app->add_option("--set", a->set, "Section.key=value of the estimator or the simulation")
      ->take_all();
  app->add_option("--ranges", a->ranges, "on | off")->check(CLI::IsMember({"on", "off"}));
  app->add_option("--anchor", a->anchors, "x,y,z from the first position, world's axes")
      ->take_all();
  app->add_option("--nlos", a->nlos, "share of the ranges without line of sight");
  app->add_option("--bias", a->bias, "added to all ranges [m]");
  app->add_option("--outage", a->outages, "from,to: no ranges [s]")->take_all();
  app->add_option("--blackout", a->blackouts, "from,to: dark images [s]")->take_all();
  app->add_option("--csv", a->csv, "errors per second to this file");
  app->add_option("--tum", a->tum, "PREFIX: writes PREFIX_<seed>.tum and PREFIX_truth.tum");
  app->add_option("--plot", a->plot, "svg file of the first seed's path and errors");
  app->add_flag("--log", a->log, "what the estimator says to standard error");
  app->add_option("--jobs", a->jobs, "runs at a time");
  app->parse(argc, argv);
}

std::vector<double> numbers(const std::string& text, std::size_t size) {
  std::vector<double> out;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) out.push_back(std::stod(word));
  if (out.size() != size) {
    throw std::invalid_argument("'" + text + "': expected " + std::to_string(size) +
                                " numbers with commas");
  }
  return out;
}

std::pair<int, int> seedRange(const std::string& text) {
  const auto dots = text.find("..");
  const int first = std::stoi(text.substr(0, dots));
  return {first, dots == std::string::npos ? first : std::stoi(text.substr(dots + 2))};
}

bool isFlight(const std::string& name) {
  const auto names = simulation::flightNames();
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// 640x480, looking along body x, image right = body -y.
void mountForward(RunSettings* s) {
  s->camera.width = 640;
  s->camera.height = 480;
  s->camera.fx = s->camera.fy = 400;
  s->camera.cx = 320;
  s->camera.cy = 240;
  Mat3 R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  s->T_B_C = {Quat(R), Vec3(0.05, 0.02, -0.01)};
}

/// The left camera of EuRoC's sensor: its body's x axis points up.
void mountEuroc(RunSettings* s) {
  s->camera.width = 752;
  s->camera.height = 480;
  s->camera.fx = 458.654;
  s->camera.fy = 457.296;
  s->camera.cx = 367.215;
  s->camera.cy = 248.375;
  s->camera.distortion = Distortion::radtan;
  s->camera.dist = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0};
  Mat3 R;
  R << 0.0148655429818, -0.999880929698, 0.00414029679422, 0.999557249008, 0.0149672133247,
      0.025715529948, -0.0257744366974, 0.00375618835797, 0.999660727178;
  s->T_B_C = {Quat(R).normalized(), Vec3(-0.0216401454975, -0.064676986768, 0.00981073058949)};
}

/// `kind`: errors as an estimator assumes them, white or constant. `harsh`: patches that drift and
/// an IMU that is not calibrated quite right, about twice the published errors on EuRoC.
void setErrors(const std::string& word, RunSettings* s) {
  if (word == "kind") s->tracks.drift_px = s->tracks.outlier_share = 0;
  if (word != "harsh") return;
  s->tracks.drift_px = 0.2;
  s->tracks.outlier_share = 0.05;
  s->imu.scale_error = s->imu.misalignment_rad = 0.002;
}

RunSettings readSettings(const Arguments& a, simulation::FlightOptions* flight_options) {
  RunSettings s;
  setErrors(a.errors, &s);
  Settings settings;
  for (const std::string& assignment : a.set) settings.set(assignment);
  SettingsReader reader(settings);
  describe(reader, s.estimator);
  describe(reader, *flight_options);
  describe(reader, s.imu);
  describe(reader, s.tracks);
  describe(reader, s.ranges);
  reader.finish();
  const std::string camera =
      a.camera.empty() ? (isFlight(a.trajectory) ? "forward" : "euroc") : a.camera;
  camera == "forward" ? mountForward(&s) : mountEuroc(&s);
  s.use_ranges = a.ranges == "on";
  s.log = a.log ? stderr : nullptr;
  if (a.nlos >= 0) s.ranges.nlos_share = a.nlos;
  s.ranges.bias_m += a.bias;
  for (const std::string& t : a.outages) {
    for (double x : numbers(t, 2)) s.ranges.outage_s.push_back(x);
  }
  for (const std::string& t : a.blackouts) {
    for (double x : numbers(t, 2)) s.tracks.blackout_s.push_back(x);
  }
  return s;
}

std::shared_ptr<const simulation::Motion> readMotion(const Arguments& a,
                                                     const simulation::FlightOptions& o) {
  if (isFlight(a.trajectory))
    return std::make_shared<simulation::Motion>(simulation::flight(a.trajectory, o));
  std::ifstream in(a.trajectory);
  if (!in) throw std::invalid_argument("cannot read " + a.trajectory);
  evaluation::ReadReport report;
  simulation::FlyAgainOptions again;
  again.from_s = a.start_s;
  again.duration_s = a.duration_s;
  return std::make_shared<simulation::Motion>(
      simulation::flyAgain(evaluation::readTrajectory(in, &report), again));
}

std::vector<RunResult> runAll(const std::shared_ptr<const simulation::Motion>& motion,
                              const RunSettings& s, std::pair<int, int> seeds, int jobs) {
  std::vector<RunResult> out;
  std::vector<std::future<RunResult>> running;
  int next = seeds.first;
  for (int seed = seeds.first; seed <= seeds.second; ++seed) {
    while (next <= seeds.second && next < seed + std::max(1, jobs)) {
      running.push_back(std::async(std::launch::async, simulateRun, motion, s, next++));
    }
    out.push_back(running[static_cast<std::size_t>(seed - seeds.first)].get());
  }
  return out;
}

double mean(const std::vector<RunResult>& runs, double (*value)(const RunResult&)) {
  double sum = 0;
  int n = 0;
  for (const RunResult& r : runs) {
    if (!r.valid) continue;
    sum += value(r);
    ++n;
  }
  return n ? sum / n : 0;
}

/// Mean over the anchors that were found; -1 if none.
double ofAnchors(const RunResult& r, double AnchorError::*value) {
  double sum = 0;
  int n = 0;
  for (const AnchorError& a : r.anchors) {
    if (!a.found) continue;
    sum += a.*value;
    ++n;
  }
  return n ? sum / n : -1;
}

/// NEES of a position per degree of freedom; -1 stays.
double perAxis(double nees) { return nees < 0 ? -1 : nees / 3; }

struct Column {
  const char* name;
  int width, decimals;
  double (*value)(const RunResult&);
};

const std::vector<Column> kColumns = {
    {"ATE m", 8, 4, [](const RunResult& r) { return r.evaluation.ate_position_m.rmse; }},
    {"smooth m", 9, 4, [](const RunResult& r) { return r.smoothed_ate_m; }},
    {"max m", 8, 4, [](const RunResult& r) { return r.evaluation.ate_position_m.max; }},
    {"end m", 8, 4, [](const RunResult& r) { return r.end_error_m; }},
    {"rel 1s m", 9, 4, [](const RunResult& r) { return r.evaluation.rpe_time.translation_m.rmse; }},
    {"jump m", 7, 3, [](const RunResult& r) { return r.largest_jump_m; }},
    {"att deg", 8, 3, [](const RunResult& r) { return r.evaluation.ate_orientation_deg.rmse; }},
    {"NEES/3", 8, 2, [](const RunResult& r) { return perAxis(r.mean_nees); }},
    {"anchor m", 9, 3, [](const RunResult& r) { return ofAnchors(r, &AnchorError::error_m); }},
    {"NEES/3", 8, 2, [](const RunResult& r) { return perAxis(ofAnchors(r, &AnchorError::nees)); }},
    {"init s", 7, 2, [](const RunResult& r) { return r.init_s; }},
    {"tracks", 7, 0, [](const RunResult& r) { return r.mean_tracks; }},
    {"ms/img", 7, 2, [](const RunResult& r) { return r.ms_per_frame; }},
    {"resets", 7, 0, [](const RunResult& r) { return static_cast<double>(r.resets); }},
};

void print(const std::vector<RunResult>& runs) {
  std::printf("%5s", "seed");
  for (const Column& c : kColumns) std::printf(" %*s", c.width, c.name);
  std::printf("\n");
  for (const RunResult& r : runs) {
    std::printf("%5d", r.seed);
    if (r.valid) {
      for (const Column& c : kColumns) std::printf(" %*.*f", c.width, c.decimals, c.value(r));
    }
    std::printf(" %s\n", r.note.c_str());
  }
  std::printf("%5s", "mean");
  for (const Column& c : kColumns) std::printf(" %*.*f", c.width, c.decimals, mean(runs, c.value));
  std::printf("\n");
  std::map<std::string, long> decisions;
  int missing = 0;
  for (const RunResult& r : runs) {
    for (const auto& [what, count] : r.decisions) decisions[what] += count;
    for (const AnchorError& a : r.anchors) missing += a.found ? 0 : 1;
  }
  if (decisions.empty()) return;
  std::printf("ranges:");
  for (const auto& [what, count] : decisions) std::printf(" %s %ld;", what.c_str(), count);
  std::printf(" anchors not found %d\n", missing);
}

void writeCsv(const std::string& file, const std::vector<RunResult>& runs) {
  std::ofstream out(file);
  out << "seed,t_s,ex_m,ey_m,ez_m,rotation_deg,yaw_deg,sx_m,sy_m,sz_m,nees,tracks,landmarks,"
         "health\n";
  for (const RunResult& r : runs) {
    TimeNs next = 0;
    for (const PoseError& e : r.errors) {
      if (e.t < next) continue;
      next = e.t + 1000000000;
      const double deg = 180 / M_PI;
      out << r.seed << ',' << toSeconds(e.t - r.errors.front().t) << ',' << e.position.x() << ','
          << e.position.y() << ',' << e.position.z() << ',' << e.rotation_rad * deg << ','
          << e.yaw_rad * deg << ',' << e.sigma.x() << ',' << e.sigma.y() << ',' << e.sigma.z()
          << ',' << e.nees << ',' << e.tracks << ',' << e.landmarks << ',' << e.health << '\n';
    }
  }
  if (!out) throw std::runtime_error("cannot write " + file);
}

void writeFiles(const Arguments& a, const simulation::Motion& motion,
                const std::vector<RunResult>& runs) {
  if (!a.csv.empty()) writeCsv(a.csv, runs);
  if (!a.tum.empty()) {
    std::ofstream truth(a.tum + "_truth.tum");
    evaluation::writeTum(truth, motion.sampled(20));
    for (const RunResult& r : runs) {
      std::ofstream out(a.tum + "_" + std::to_string(r.seed) + ".tum");
      evaluation::writeTum(out, r.estimate);
    }
  }
  if (!a.plot.empty() && runs.front().valid) {
    const std::vector<evaluation::NamedResult> named{
        {"seed " + std::to_string(runs.front().seed), runs.front().evaluation}};
    std::ofstream out(a.plot);
    out << evaluation::toSvg(evaluation::comparisonFigure(runs.front().truth, named,
                                                          evaluation::describeComparison({})));
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(kExamples);
  Arguments a;
  try {
    parse(argc, argv, &app, &a);
    simulation::FlightOptions flight_options;
    RunSettings settings = readSettings(a, &flight_options);
    const auto motion = readMotion(a, flight_options);
    const Vec3 start = motion->poseAt(motion->begin()).p;
    for (const std::string& text : a.anchors) {
      const std::vector<double> p = numbers(text, 3);
      for (int k = 0; k < 3; ++k) {
        settings.ranges.anchor_m.push_back(start[k] + p[static_cast<std::size_t>(k)]);
      }
    }
    const std::vector<RunResult> runs = runAll(motion, settings, seedRange(a.seeds), a.jobs);
    std::printf("%s: %.1f m in %.1f s\n", a.trajectory.c_str(), motion->pathLength(),
                motion->duration());
    print(runs);
    writeFiles(a, *motion, runs);
  } catch (const CLI::ParseError& e) {
    return app.exit(e);
  } catch (const std::exception& e) {
    std::cerr << "simulate_runs: " << e.what() << '\n';
    return 2;
  }
  return 0;
}
