#pragma once
/// What `check` found, for people and for programs.
#include <string>
#include <vector>

#include "recordings/recording_check.h"
#include "recordings/source_reader.h"

namespace vir::app {

void printStreams(const std::vector<check::StreamSummary>& streams);
void printFindings(const std::vector<check::Finding>& findings);
/// What is wrong with the file itself, before what is wrong with what is in it. `streams`: what was
/// read of it.
void addFindings(const SourceReport& source, const std::vector<check::StreamSummary>& streams,
                 std::vector<check::Finding>* findings);
/// "fine", "doubtful" or "unusable".
const char* verdictName(check::Severity worst);
/// Throws std::runtime_error if it cannot be written.
void writeJson(const std::string& path, const RecordingCheck& recording,
               const std::vector<check::Finding>& findings);

}  // namespace vir::app
