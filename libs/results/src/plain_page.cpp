#include "vir/results/plain_page.h"

#include "page_files.h"
#include "vir/core/markup.h"

namespace vir::results {

std::string plainPage(const std::string& title, const std::string& content) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         escapedMarkup(title) + "</title>\n<style>\n" + page::page_css + "</style></head><body>\n" +
         content + "<p class=\"small\">vir-slam " VIR_VERSION "</p>\n</body></html>\n";
}

}  // namespace vir::results
