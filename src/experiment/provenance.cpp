#include "experiment/provenance.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <ctime>
#include <fstream>
#include <string>
#include <thread>

#include "build_commit.h"
#include "build_libraries.h"
#include "core/content_hash.h"
#include "core/image_io.h"
#include "core/parallel.h"
#include "experiment/input_files.h"

namespace truescatter {

using nlohmann::json;

namespace {

std::string processor() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

json libraries() {
  json versions = json::object();
  for (const auto& [name, version] : kLibraries) versions[name] = version;
  return versions;
}

json machine() {
  utsname system{};
  uname(&system);
  return {{"system", fmt::format("{} {}", system.sysname, system.release)},
          {"processor", processor()},
          {"cores", std::thread::hardware_concurrency()},
          {"jobs", job_count()}};
}

std::string hash_of(const std::string& text) {
  ContentHash hash;
  hash.append(text);
  return hash.hex();
}

}  // namespace

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday,
                     utc.tm_hour, utc.tm_min, utc.tm_sec);
}

std::string experiment_hash(const ExperimentSpec& spec) { return hash_of(to_toml(spec)); }

std::string software_name() {
  return fmt::format("truescatter {} ({}{})", TRUESCATTER_VERSION, TRUESCATTER_COMMIT,
                     TRUESCATTER_COMMIT_DIRTY ? " with changes" : "");
}

json program_provenance() {
  return {{"version", TRUESCATTER_VERSION},
          {"commit", TRUESCATTER_COMMIT},
          {"commit_dirty", TRUESCATTER_COMMIT_DIRTY},
          {"program", hash_of_file("/proc/self/exe")},
          {"image_library", hash_of_file(image_codec_file())},
          {"compiler", TRUESCATTER_COMPILER},
          {"build_type", TRUESCATTER_BUILD_TYPE},
          {"instruction_set", TRUESCATTER_ARCH},
          {"libraries", libraries()}};
}

json file_provenance(const std::vector<std::filesystem::path>& inputs) {
  json entries = program_provenance();
  entries["machine"] = machine();
  entries["inputs"] = json::object();
  for (const std::filesystem::path& input : inputs) entries["inputs"][input.string()] = hash_of_file(input);
  return entries;
}

ImageTexts picture_origin(const json& provenance) {
  return {{"Software", software_name()},
          {"truescatter:experiment", provenance.at("experiment").get<std::string>()}};
}

json provenance(const gpu::Context& context, const ExperimentSpec& spec) {
  json entries = program_provenance();
  entries["gl_context"] = gpu::name_of(context.backend());
  entries["gl_software"] = context.is_software();
  entries["gl_renderer"] = context.renderer();
  entries["gl_version"] = context.version();
  entries["rasteriser_threads"] = context.rasteriser_threads();
  entries["machine"] = machine();
  entries["experiment"] = experiment_hash(spec);
  entries["inputs"] = input_hashes(spec);
  return entries;
}

std::string provenance_difference(const json& before, const json& now) {
  const auto compared = [](json provenance) {
    if (provenance.contains("machine")) {
      provenance["machine"].erase("jobs");
      provenance["machine"].erase("system");
    }
    return provenance.flatten();
  };
  const json old_entries = compared(before);
  const json new_entries = compared(now);
  for (const json& side : {old_entries, new_entries}) {
    for (const auto& [key, value] : side.items()) {
      const json was = old_entries.value(key, json());
      const json is = new_entries.value(key, json());
      if (was != is) return fmt::format("{} was {} and is {}", key.substr(1), was.dump(), is.dump());
    }
  }
  return "";
}

}  // namespace truescatter
