#include "core/csv.h"

#include <algorithm>
#include <utility>

#include "core/file.h"
#include "core/parse_number.h"

namespace truescatter {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return text.substr(0, 0);
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace

CsvReader::CsvReader(const std::filesystem::path& path, std::vector<std::string> columns, Header header)
    : name_(path.string()), text_(read_text_file(path)), columns_(std::move(columns)), rest_(text_) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
  const bool any = take_line();
  if (any && std::equal(cells_.begin(), cells_.end(), columns_.begin(), columns_.end())) return;
  if (header == Header::required) {
    throw_input_error({name_, 1, 0}, "\"{}\" where the header \"{}\" is needed", trimmed(line_text_),
                      fmt::join(columns_, ","));
  }
  row_is_waiting_ = any;
}

// Splits the next line into cells. False at the end, which empty lines belong to.
bool CsvReader::take_line() {
  if (rest_.find_first_not_of(" \t\r\v\f\n") == std::string_view::npos) return false;
  const std::size_t end = rest_.find('\n');
  line_text_ = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  ++line_;
  cells_.clear();
  std::string_view left = line_text_;
  while (true) {
    const std::size_t comma = left.find(',');
    cells_.push_back(trimmed(left.substr(0, comma)));
    if (comma == std::string_view::npos) return true;
    left.remove_prefix(comma + 1);
  }
}

bool CsvReader::next() {
  if (!std::exchange(row_is_waiting_, false) && !take_line()) return false;
  ++rows_;
  if (trimmed(line_text_).empty()) throw_input_error(where(), "the line is empty, and rows follow");
  if (cells_.size() != columns_.size()) {
    throw_input_error(where(), "\"{}\" has {} {}, and needs {}: {}", trimmed(line_text_), cells_.size(),
                      cells_.size() == 1 ? "value" : "values", columns_.size(), fmt::join(columns_, ","));
  }
  return true;
}

double CsvReader::number(std::size_t column) const {
  return parse_finite(cells_[column], where(column), columns_[column]);
}

int CsvReader::whole(std::size_t column) const {
  return parse_integer(cells_[column], where(column), columns_[column]);
}

SourceLocation CsvReader::where(std::size_t column) const {
  return {name_, line_, static_cast<int>(cells_[column].data() - line_text_.data()) + 1};
}

}  // namespace truescatter
