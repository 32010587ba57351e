#include "experiment/provenance.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <ctime>
#include <fstream>
#include <string>
#include <thread>

#include "build_commit.h"
#include "core/parallel.h"

namespace truescatter {
namespace {

std::string processor() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday,
                     utc.tm_hour, utc.tm_min, utc.tm_sec);
}

}  // namespace

nlohmann::json provenance(const gpu::Context& context) {
  utsname system{};
  uname(&system);
  return {{"version", TRUESCATTER_VERSION},
          {"commit", TRUESCATTER_COMMIT},
          {"commit_dirty", TRUESCATTER_COMMIT_DIRTY},
          {"compiler", TRUESCATTER_COMPILER},
          {"build_type", TRUESCATTER_BUILD_TYPE},
          {"instruction_set", TRUESCATTER_ARCH},
          {"gl_context", gpu::name_of(context.backend())},
          {"gl_software", context.is_software()},
          {"gl_renderer", context.renderer()},
          {"gl_version", context.version()},
          {"rasteriser_threads", context.rasteriser_threads()},
          {"machine",
           {{"system", fmt::format("{} {}", system.sysname, system.release)},
            {"processor", processor()},
            {"cores", std::thread::hardware_concurrency()},
            {"jobs", job_count()}}},
          {"finished_utc", now_utc()}};
}

}  // namespace truescatter
