#pragma once
/// The files of libs/results/page, as they are (cmake/embed_text.cmake).

namespace vir::results::page {

extern const char* const page_html;
extern const char* const page_css;
extern const char* const clock_js;
extern const char* const chart_js;
extern const char* const map_js;
extern const char* const scene_js;
extern const char* const parts_js;
extern const char* const run_js;
extern const char* const meeting_js;

}  // namespace vir::results::page
