#pragma once
/// Recordings with a fault, and what `vir-slam check` says of them.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir::test {

struct Row {
  long long t = 0;
  std::vector<double> v;  ///< numbers behind the stamp
  std::string rest;       ///< the line behind the stamp, comma included
};

/// The beginning of a recording, its tables rewritten; images are links.
class Variant {
 public:
  explicit Variant(const std::filesystem::path& source, double seconds = 15)
      : source_(source / "mav0") {
    std::filesystem::create_directories(mav0());
    for (const auto& item : std::filesystem::directory_iterator(source_)) {
      const std::filesystem::path folder = mav0() / item.path().filename();
      std::filesystem::create_directories(folder);
      for (const auto& file : std::filesystem::directory_iterator(item.path())) {
        std::filesystem::create_symlink(std::filesystem::canonical(file.path()),
                                        folder / file.path().filename());
      }
    }
    end_ = rows("cam0").front().t + static_cast<long long>(1e9 * seconds);
    for (const char* name : {"cam0", "imu0", "uwb0"}) {
      if (std::filesystem::exists(source_ / name))
        rewrite(name, "#t", [](const Row& r) { return line(r.t, r.rest); });
    }
  }

  std::filesystem::path mav0() const { return temp_ / "r/mav0"; }
  std::string folder() const { return quoted((temp_ / "r").string()); }
  std::string out(const std::string& name) const { return (temp_ / name).string(); }

  static std::string line(long long t, const std::string& rest) { return std::to_string(t) + rest; }
  static std::string line(long long t, const std::vector<double>& v) {
    std::ostringstream s;
    s << t << std::setprecision(9);
    for (const double x : v) s << "," << x;
    return s.str();
  }

  void rewrite(const std::string& sensor, const std::string& header,
               const std::function<std::string(const Row&)>& write) const {
    std::string text = header + "\n";
    for (const Row& row : rows(sensor)) {
      if (row.t <= end_) text += write(row) + "\n";
    }
    const std::filesystem::path file = mav0() / sensor / "data.csv";
    std::filesystem::remove(file);
    writeText(file, text);
  }
  void imu(const std::function<void(std::vector<double>*)>& change,
           const std::string& header = "#t,wx,wy,wz,ax,ay,az") const {
    rewrite("imu0", header, [&](const Row& r) {
      std::vector<double> v = r.v;
      change(&v);
      return line(r.t, v);
    });
  }

 private:
  std::vector<Row> rows(const std::string& sensor) const {
    std::ifstream in(source_ / sensor / "data.csv");
    std::vector<Row> out;
    for (std::string text; std::getline(in, text);) {
      if (text.empty() || text[0] == '#') continue;
      if (text.back() == '\r') text.pop_back();
      Row r;
      const std::size_t comma = text.find(',');
      r.t = std::stoll(text);
      r.rest = text.substr(comma);
      std::istringstream fields(text.substr(comma + 1));
      for (std::string f; std::getline(fields, f, ',');) {
        try {
          r.v.push_back(std::stod(f));
        } catch (const std::exception&) {
        }
      }
      out.push_back(r);
    }
    return out;
  }

  TempFolder temp_;
  std::filesystem::path source_;
  long long end_ = 0;
};

/// What check says of a variant.
struct Checked {
  int code = -1;
  std::string text;
  std::vector<std::string> kinds;  ///< more than notes, the worst first
};

inline Checked check(const Variant& v, const std::string& more = "") {
  const auto o = virSlam("check " + v.folder() + " --json " + quoted(v.out("c.json")) + " " + more);
  Checked c{o.code, o.text, {}};
  std::ifstream in(v.out("c.json"));
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (json.is_discarded()) return c;
  for (const auto& f : json["findings"]) {
    if (f["severity"] != "note") c.kinds.push_back(f["kind"]);
  }
  return c;
}

inline bool has(const Checked& c, const std::string& kind) {
  return std::find(c.kinds.begin(), c.kinds.end(), kind) != c.kinds.end();
}

}  // namespace vir::test
