#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/file.h"
#include "support/environment.h"
#include "support/results_schema.h"
#include "support/run_program.h"
#include "support/temp_dir.h"

namespace truescatter::test {

// A sphere of 8 mm that does not fill its view: an experiment up to that view's size in pixels.
inline const std::string kBallScene = R"(
[scene]
mesh = "builtin:sphere"
[scene.parameters]
radius_mm = 8.0
edge_mm = 2.0
[[light]]
direction = [0.8, 0.4, 0.5]
[[view]]
name = "front"
eye_mm = [0.0, 0.0, 100.0]
fov_deg = 11.0
)";

// A small experiment: 48 x 48 pixels of a square of 20 mm that fills the frame.
inline const std::string kTiny = R"(name = "tiny"

[scene]
mesh = "builtin:plane"
[scene.parameters]
size_mm = 20.0
edge_mm = 5.0

[[light]]
direction = [0.0, 0.5, 1.0]

[[view]]
name = "front"
eye_mm = [0.0, 0.0, 100.0]
fov_deg = 10.0
width_px = 48
height_px = 48

[[profile]]
name = "spike-and-base"

[[method]]
name = "none"

[[method]]
name = "pscbf"

[timing]
warm_up = 0
repeats = 1
)";

// The text with one piece replaced, which must be there.
inline std::string with(std::string text, const std::string& piece, const std::string& replacement) {
  const std::size_t at = text.find(piece);
  if (at == std::string::npos) throw std::runtime_error("no such piece: " + piece);
  return text.replace(at, piece.size(), replacement);
}

// Runs the built program in a folder of its own, with a cache of its own.
class Cli : public testing::Test {
 protected:
  ProgramResult truescatter(const std::vector<std::string>& arguments) const {
    return run_program(TRUESCATTER_BINARY, arguments, folder_.path());
  }
  // `run` of an experiment's text, with results in out/.
  ProgramResult run(const std::string& experiment, const std::vector<std::string>& arguments = {}) const {
    folder_.write("e.toml", experiment);
    std::vector<std::string> all = {"run", "e.toml", "--out", "out"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const ProgramResult result = truescatter(all);
    if (result.exit_code <= 1 && exists("out/results.json")) expect_schema("out/results.json");
    return result;
  }
  // A results.json is laid out as its schema says.
  void expect_schema(const std::string& name) const { EXPECT_EQ(schema_violations(json(name)), "") << name; }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_.path() / name); }
  std::string text(const std::string& name) const { return read_text_file(folder_.path() / name); }
  nlohmann::json json(const std::string& name) const { return nlohmann::json::parse(text(name)); }

  TempDir folder_;
  TempDir cache_;
  EnvironmentVariable cache_variable_{"TRUESCATTER_CACHE", cache_.path().string()};
};

inline bool contains(const std::string& text, const std::string& piece) {
  return text.find(piece) != std::string::npos;
}

// Wrong input: exit code 2, a message that starts with the program's name and says what is wrong, no results.
class CliErrors : public Cli {
 protected:
  void expect_refused(const ProgramResult& result, const std::vector<std::string>& pieces) const {
    EXPECT_EQ(result.exit_code, 2) << result.err;
    for (const std::string& piece : pieces)
      EXPECT_TRUE(contains(result.err, piece)) << piece << "\nin\n" << result.err;
    EXPECT_FALSE(exists("out"));
    EXPECT_FALSE(exists("runs"));
  }
};

// What needs no computing is refused by --dry-run alike: to the letter, the stages' lines of `run` aside.
class CliErrorsBeforeComputing : public CliErrors {
 protected:
  ProgramResult run(const std::string& experiment, std::vector<std::string> arguments = {}) const {
    const ProgramResult result = Cli::run(experiment, arguments);
    arguments.emplace_back("--dry-run");
    const ProgramResult dry = Cli::run(experiment, arguments);
    EXPECT_EQ(dry.exit_code, result.exit_code);
    EXPECT_EQ(dry.out, "");
    EXPECT_TRUE(dry.err.starts_with("truescatter: ")) << dry.err;
    EXPECT_TRUE(result.err.ends_with(dry.err)) << dry.err << "\nis not the end of\n" << result.err;
    return result;
  }
};

}  // namespace truescatter::test
