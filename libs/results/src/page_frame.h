#pragma once
/// What all pages share: libs/results/page/page.html filled in, and shapes of their JSON.
#include <string>
#include <vector>

#include "vir/types/anchor.h"
#include "vir/types/state.h"

namespace vir::results {

struct PageParts {
  std::string title;    ///< as it is: escaped here
  std::string content;  ///< markup, with an element `live` for what the script makes
  std::string json;     ///< for the script; must hold no `<`
  std::string script;   ///< the page's own, after clock, chart, map and scene
};
std::string filledPage(const PageParts& parts);

/// A bulleted list; the lines are escaped here.
std::string listHtml(const std::vector<std::string>& lines);

/// Where a page comes from: program, time of the first frame (0: none), and command (may be empty).
/// The date is the recording's: a page is the same whenever it is made.
std::string originHtml(const std::string& command, TimeNs first_frame);

/// What would end a script is written so that JSON reads the same.
std::string insideScript(const std::string& json);

/// Every n-th, so that at most 3000 are left.
template <typename Vector>
std::vector<typename Vector::value_type> thinnedForPage(const Vector& all) {
  constexpr std::size_t kMost = 3000;
  std::vector<typename Vector::value_type> out;
  for (std::size_t i = 0; i < all.size(); i += all.size() / kMost + 1) out.push_back(all[i]);
  return out;
}

/// {"id", "state", "p", "root" (rows of a root of the covariance), "mirror", "truth": null}, with
/// null for positions that are not known.
std::string anchorJson(const Anchor& anchor, const Vec3* truth);

/// [[x...], [y...], [z...]], thinned out.
std::string pointsJson(const std::vector<Landmark>& landmarks);

/// "name" as JSON text.
std::string jsonText(const std::string& text);

/// {"t", "x", "y", "z"}: times since `start`.
std::string pathJson(const Trajectory& path, TimeNs start);

}  // namespace vir::results
