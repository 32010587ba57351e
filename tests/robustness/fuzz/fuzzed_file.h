#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "core/error.h"

namespace truescatter::fuzz {

// The folder of a fuzzer's process, in memory where the system has such a place.
inline std::filesystem::path fuzz_folder() {
  const std::filesystem::path shared = "/dev/shm";
  return (std::filesystem::is_directory(shared) ? shared : std::filesystem::temp_directory_path()) /
         ("truescatter-fuzz-" + std::to_string(::getpid()));
}

// A file in it with these bytes.
inline std::filesystem::path fuzzed_file(const std::string& name, std::string_view bytes) {
  static const bool made = [] {
    std::atexit([] { std::filesystem::remove_all(fuzz_folder()); });
    return std::filesystem::create_directories(fuzz_folder());
  }();
  (void)made;
  const std::filesystem::path file = fuzz_folder() / name;
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return file;
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// Reads a file by `read`. That throws an Error of wrong input which names the file, or it succeeds: any other
// exception is a finding, as is a crash.
template <typename Read>
void read_or_refuse(const std::filesystem::path& file, Read&& read) {
  try {
    read(file);
  } catch (const Error& error) {
    const std::string_view message = error.what();
    const bool named = message.find(file.filename().string()) != std::string_view::npos;
    if (error.kind() == ErrorKind::input && named) return;
    std::fprintf(stderr, "a message that names no file, or blames the run: %s\n", error.what());
    std::abort();
  }
}

}  // namespace truescatter::fuzz
