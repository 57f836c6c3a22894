#include "setup/given_survey.h"

#include <filesystem>

#include "commands/commands.h"
#include "recordings/companion.h"

namespace vir::app {
namespace {

constexpr const char *kSection = "Ranges", *kKey = "surveyed_anchors", *kNames = "anchor_names";

}  // namespace

void takeSurvey(const std::string& anchors, const std::string& rawlog, Settings* settings) {
  namespace fs = std::filesystem;
  std::string path = anchors;
  if (path.empty()) {
    const Setting* named = settings->find(kSection, kKey);
    if (named == nullptr || named->value.empty()) return;
    path = named->value;
    const bool from_file = named->origin.line > 0;
    if (from_file && fs::path(path).is_relative()) {
      path = (fs::path(named->origin.file).parent_path() / path).string();
    }
  }
  requireFile(path, "table of anchors");
  const std::string absolute = fs::absolute(path).lexically_normal().string();
  settings->set(std::string(kSection) + "." + kKey + "=" + absolute);
  const Setting* names = settings->find(kSection, kNames);
  if (rawlog.empty() || (names != nullptr && !names->value.empty())) return;
  const std::string mapped = anchorNamesOf(rawlog);
  if (!mapped.empty()) settings->set(std::string(kSection) + "." + kNames + "=" + mapped);
}

}  // namespace vir::app
