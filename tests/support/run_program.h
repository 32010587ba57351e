#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/temp_dir.h"

namespace truescatter::test {

struct ProgramResult {
  int exit_code = -1;  // -1: ended by a signal
  std::string out;
  std::string err;
};

// Runs a program in `folder` with this process' environment and waits for it.
inline ProgramResult run_program(const std::string& program, const std::vector<std::string>& arguments,
                                 const std::filesystem::path& folder) {
  const TempDir captured;
  const std::string out_path = (captured.path() / "out").string();
  const std::string err_path = (captured.path() / "err").string();
  std::vector<std::string> words = {program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child == 0) {
    const int out = open(out_path.c_str(), O_WRONLY | O_CREAT, 0600);
    const int err = open(err_path.c_str(), O_WRONLY | O_CREAT, 0600);
    if (chdir(folder.c_str()) == 0 && dup2(out, STDOUT_FILENO) >= 0 && dup2(err, STDERR_FILENO) >= 0) {
      execv(program.c_str(), argv.data());
    }
    _exit(127);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const auto text_of = [](const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
  };
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out_path), text_of(err_path)};
}

}  // namespace truescatter::test
