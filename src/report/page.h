#pragma once

#include <string>

namespace truescatter {

// What varies from page to page; each is ready to stand where it goes.
struct PageContents {
  std::string title;     // HTML
  std::string results;   // JSON for a script block
  std::string pictures;  // JSON for a script block
  std::string values;    // JSON for a script block
};

// The whole page: the template with its styles and scripts, and these contents.
std::string make_page(const PageContents& contents);

}  // namespace truescatter
