#include "core/file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "core/error.h"

namespace truescatter {

std::filesystem::path temporary_sibling(const std::filesystem::path& path) {
  return path.parent_path() /
         fmt::format(".{}.{}.part{}", path.stem().string(), getpid(), path.extension().string());
}

bool is_temporary_name(std::string_view name) {
  const std::size_t part = name.rfind(".part");
  if (!name.starts_with('.') || part == std::string_view::npos) return false;
  const std::string_view before = name.substr(0, part);
  const std::size_t process = before.find_last_not_of("0123456789");
  return process != std::string_view::npos && process > 0 && process + 1 < before.size() &&
         before[process] == '.';
}

void commit_temporary(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  std::error_code failure;
  std::filesystem::rename(temporary, path, failure);
  if (!failure) return;
  std::error_code ignored;
  std::filesystem::remove(temporary, ignored);
  throw_run_error("{}: cannot write this file: {}", path.string(), failure.message());
}

void exchange_names(const std::filesystem::path& a, const std::filesystem::path& b,
                    const std::filesystem::path& spare) {
  if (renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0) return;
  const int reason = errno;
  const bool cannot = reason == EINVAL || reason == ENOSYS || reason == ENOTSUP;
  if (!cannot)
    throw_run_error("{}: cannot be replaced: {}", b.string(), std::generic_category().message(reason));
  exchange_names_in_steps(a, b, spare);
}

void exchange_names_in_steps(const std::filesystem::path& a, const std::filesystem::path& b,
                             const std::filesystem::path& spare) {
  std::error_code failure;
  std::error_code ignored;
  std::filesystem::rename(b, spare, failure);
  if (!failure) {
    std::filesystem::rename(a, b, failure);
    if (failure) {
      std::filesystem::rename(spare, b, ignored);
    } else {
      std::filesystem::rename(spare, a, failure);
      if (failure) {
        std::filesystem::rename(b, a, ignored);
        std::filesystem::rename(spare, b, ignored);
      }
    }
  }
  if (failure) throw_run_error("{}: cannot be replaced: {}", b.string(), failure.message());
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure) throw_run_error("{}: cannot make this folder: {}", folder.string(), failure.message());
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
