#include "core/file.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "core/error.h"

namespace truescatter {

std::filesystem::path temporary_sibling(const std::filesystem::path& path) {
  return path.parent_path() /
         fmt::format(".{}.{}.part{}", path.stem().string(), getpid(), path.extension().string());
}

void commit_temporary(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  std::error_code failure;
  std::filesystem::rename(temporary, path, failure);
  if (!failure) return;
  std::error_code ignored;
  std::filesystem::remove(temporary, ignored);
  throw_run_error("{}: cannot write this file: {}", path.string(), failure.message());
}

void write_text_file(const std::filesystem::path& path, std::string_view text) {
  const std::filesystem::path temporary = temporary_sibling(path);
  {
    std::ofstream stream(temporary, std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.flush();
    if (!stream) {
      std::error_code ignored;
      std::filesystem::remove(temporary, ignored);
      throw_run_error("{}: cannot write this file (permissions, or a full disk?)", path.string());
    }
  }
  commit_temporary(temporary, path);
}

std::string read_text_file(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) throw_input_error({path.string()}, "no such file");
  if (std::filesystem::is_directory(path))
    throw_input_error({path.string()}, "is a folder; a file is needed");
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw_input_error({path.string()}, "cannot read this file");
  return text.str();
}

std::string expand_environment(const std::string& text) {
  std::string result;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t open = text.find("${", at);
    if (open == std::string::npos) return result + text.substr(at);
    const std::size_t close = text.find('}', open);
    if (close == std::string::npos) throw_input_error({}, "'{}': '${{' without a closing '}}'", text);
    const std::string name = text.substr(open + 2, close - open - 2);
    const char* value = std::getenv(name.c_str());
    if (value == nullptr) throw_input_error({}, "'{}': the environment variable {} is not set", text, name);
    result += text.substr(at, open - at) + value;
    at = close + 1;
  }
  return result;
}

}  // namespace truescatter
