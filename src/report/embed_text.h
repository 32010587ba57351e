#pragma once

#include <string>
#include <string_view>

namespace truescatter {

// Text that stands in HTML content or in a quoted attribute.
std::string html_escaped(std::string_view text);

// JSON that stands in a script block. "<" occurs in JSON only inside strings, where \u003c means the same;
// without it neither "</script>" nor "<!--" can end or change the block.
std::string script_block_json(std::string json);

// RFC 4648, padded.
std::string base64(std::string_view bytes);

}  // namespace truescatter
