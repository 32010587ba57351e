#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace truescatter {

// Reads a table of numbers in comma-separated text, row by row, and knows where it is. The first line names
// the columns, in the order asked for. Blanks around a cell, a byte order mark, CRLF and empty lines at the
// end are allowed; quotes and comments are not.
class CsvReader {
 public:
  enum class Header { required, optional };

  // Throws Error (input) that names the file, and the line of a header that is not there.
  CsvReader(const std::filesystem::path& path, std::vector<std::string> columns,
            Header header = Header::required);
  CsvReader(const CsvReader&) = delete;
  CsvReader& operator=(const CsvReader&) = delete;

  // Moves to the next row. False at the end. Throws Error (input) at a row of another number of cells.
  bool next();

  // A cell of the row as a finite number, or as a whole one. Throws Error (input) at the cell.
  double number(std::size_t column) const;
  int whole(std::size_t column) const;

  std::size_t rows() const { return rows_; }  // that next() has moved to
  // The row's line; with a column, the cell.
  SourceLocation where() const { return {name_, line_, 0}; }
  SourceLocation where(std::size_t column) const;
  const std::string& name() const { return name_; }

 private:
  bool take_line();

  std::string name_;
  std::string text_;
  std::vector<std::string> columns_;
  std::string_view rest_;
  std::string_view line_text_;
  std::vector<std::string_view> cells_;
  int line_ = 0;
  std::size_t rows_ = 0;
  bool row_is_waiting_ = false;  // read in place of an optional header
};

}  // namespace truescatter
