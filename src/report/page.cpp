#include "report/page.h"

#include <array>
#include <cassert>
#include <functional>
#include <map>
#include <string_view>

namespace truescatter {

// Defined by the build from the files in page/.
namespace report_page {
std::string embedded(std::string_view path);
}  // namespace report_page

namespace {

std::string page_file(std::string_view name) {
  std::string text = report_page::embedded("report/page/" + std::string(name));
  assert(!text.empty());
  return text;
}

std::string all_scripts() {
  std::string text;
  for (const char* name :
       {"base.js",         "data.js",    "sort.js",    "chart.js",    "labels.js",  "svg_chart.js",
        "plotly_chart.js", "summary.js", "seen.js",    "scatter.js",  "pareto.js",  "halo.js",
        "seam.js",         "values.js",  "inspect.js", "pictures.js", "buffers.js", "viewer.js",
        "fit.js",          "terms.js",   "sweep.js",   "paths.js",    "tables.js",  "ladder.js",
        "details.js",      "state.js",   "hover.js",   "keys.js",     "report.js"}) {
    text += page_file(name);
  }
  return text;
}

// plotly.js with its licence's text, in a script block of its own; nothing in a program built without it.
std::string plotly_block() {
  const std::string script = report_page::embedded("plotly-basic.min.js");
  if (script.empty()) return {};
  // Neither text ends the comment or the block: the build has checked both files' hashes, a test the page.
  return "<script id=\"plotly\">\n/*\n" + report_page::embedded("LICENSE") + "*/\n" + script + "</script>";
}

}  // namespace

std::string make_page(const PageContents& contents) {
  const std::map<std::string, std::string, std::less<>> values = {
      {"title", contents.title},       {"style", page_file("report.css")}, {"results", contents.results},
      {"pictures", contents.pictures}, {"values", contents.values},        {"plotly", plotly_block()},
      {"scripts", all_scripts()}};
  const std::string text = page_file("report.html");
  // One pass: what is put in is never searched for placeholders itself.
  std::string page;
  std::size_t from = 0;
  for (std::size_t at = text.find("{{"); at != std::string::npos; at = text.find("{{", from)) {
    const std::size_t end = text.find("}}", at);
    assert(end != std::string::npos);
    page.append(text, from, at - from);
    page += values.at(text.substr(at + 2, end - at - 2));
    from = end + 2;
  }
  return page.append(text, from);
}

}  // namespace truescatter
