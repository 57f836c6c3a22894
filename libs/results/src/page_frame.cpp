#include "page_frame.h"

#include <Eigen/Cholesky>
#include <cstddef>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "json_columns.h"
#include "page_files.h"
#include "vir/core/markup.h"
#include "vir/results/plain_page.h"

namespace vir::results {
namespace {

using Json = nlohmann::ordered_json;

Json vectorOf(const Vec3& v) { return v.allFinite() ? Json({v.x(), v.y(), v.z()}) : Json(nullptr); }

std::string dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// The frame with each of its marks replaced, which come in this order.
std::string filled(std::initializer_list<std::pair<const char*, std::string_view>> parts) {
  const std::string_view frame = page::page_html;
  std::size_t size = frame.size();
  for (const auto& part : parts) size += part.second.size();
  std::string out;  // megabytes after a long run: not to be moved while it grows
  out.reserve(size);
  std::size_t from = 0;
  for (const auto& [mark, text] : parts) {
    const std::string whole = std::string("<!--") + mark + "-->";
    const std::size_t at = frame.find(whole, from);
    out += frame.substr(from, at - from);
    out += text;
    from = at + whole.size();
  }
  out += frame.substr(from);
  return out;
}

}  // namespace

std::string filledPage(const PageParts& parts) {
  const std::string scripts = std::string(page::clock_js) + page::chart_js + page::map_js +
                              page::scene_js + page::parts_js + parts.script;
  const std::string title = escapedMarkup(parts.title);
  return filled({{"title", title},
                 {"style", page::page_css},
                 {"content", parts.content},
                 {"data", parts.json},
                 {"script", scripts}});
}

std::string listHtml(const std::vector<std::string>& lines) {
  std::string t = "<ul>\n";
  for (const std::string& line : lines) t += "<li>" + escapedMarkup(line) + "</li>\n";
  return t + "</ul>\n";
}

std::string originHtml(const std::string& command, TimeNs first_frame) {
  std::string text = "vir-slam " VIR_VERSION;
  constexpr TimeNs kNoClock =
      946'684'800'000'000'000;  // before the year 2000: counted from power-up
  if (first_frame > kNoClock) text += "; first frame at " + dateText(first_frame) + " = 0 s";
  std::string page = "<p class=\"small\">" + text + "</p>\n";
  if (!command.empty()) page += "<p class=\"small\">" + escapedMarkup(command) + "</p>\n";
  return page;
}

std::string insideScript(const std::string& json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

std::string anchorJson(const Anchor& a, const Vec3* truth) {
  const bool known = a.has_position && a.p_W.allFinite();
  Json json{{"id", a.id}, {"state", name(a.state)}};
  json["p"] = known ? vectorOf(a.p_W) : Json(nullptr);
  const Mat3 L = Eigen::LLT<Mat3>(a.covariance + 1e-12 * Mat3::Identity()).matrixL();
  json["root"] = Json::array();
  for (int r = 0; r < 3; ++r) {
    json["root"].push_back(vectorOf(L.allFinite() ? Vec3(L.row(r)) : Vec3::Zero()));
  }
  json["mirror"] = a.state == AnchorState::mirror_open ? vectorOf(a.mirror_p_W) : Json(nullptr);
  json["truth"] = truth != nullptr ? vectorOf(*truth) : Json(nullptr);
  return dumped(json);
}

std::string pointsJson(const std::vector<Landmark>& landmarks) {
  std::vector<Vec3> finite;
  for (const Landmark& l : landmarks) {
    if (l.p_W.allFinite()) finite.push_back(l.p_W);
  }
  const std::vector<Vec3> some = thinnedForPage(finite);
  std::string out = "[";
  for (int axis = 0; axis < 3; ++axis) {
    out += axis > 0 ? ",[" : "[";
    for (std::size_t i = 0; i < some.size(); ++i) {
      out += (i > 0 ? "," : "") + jsonNumber(some[i][axis], 2);
    }
    out += "]";
  }
  return out + "]";
}

std::string jsonText(const std::string& text) { return dumped(text); }

std::string pathJson(const Trajectory& path, TimeNs start) {
  std::string out = "{";
  addColumn(
      "t", path.size(), 3, [&](std::size_t i) { return toSeconds(path[i].t - start); }, &out);
  int axis = 0;
  for (const char* name : {"x", "y", "z"}) {
    addColumn(
        name, path.size(), 3, [&](std::size_t i) { return path[i].T_W_B.p[axis]; }, &out);
    ++axis;
  }
  return out + "}";
}

}  // namespace vir::results
