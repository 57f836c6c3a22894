#include "vir/results/plain_page.h"

#include <ctime>

#include "page_files.h"
#include "page_frame.h"
#include "vir/core/markup.h"

namespace vir::results {

std::string plainPage(const std::string& title, const std::string& content,
                      const std::string& command) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         escapedMarkup(title) + "</title>\n<style>\n" + page::page_css + "</style></head><body>\n" +
         content + originHtml(command, 0) + "</body></html>\n";
}

std::string dateText(TimeNs t) {
  const auto seconds = static_cast<std::time_t>(t / 1'000'000'000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char date[40];
  std::strftime(date, sizeof date, "%Y-%m-%d %H:%M:%S UTC", &utc);
  return date;
}

}  // namespace vir::results
