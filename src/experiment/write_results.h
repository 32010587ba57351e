#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiment/join_pieces.h"

namespace truescatter {

// The experiment as it was run, which a result and a part hold.
inline constexpr const char* kResolvedFile = "experiment.resolved.toml";

// What a run ended with.
struct RunOutcome {
  std::vector<std::string> exceeded;  // one line per stated threshold that was exceeded
};

// What the computing took of memory.
struct MemoryTaken {
  std::uint64_t peak_bytes;
  std::uint64_t limit_bytes;
};

// Writes results.json, results.csv, experiment.resolved.toml and the pictures in maps/ into `folder`, out of
// its finished pieces, every one of which is there. `key`: the provenance that they were computed under;
// `machines`: all that computed them, where they were several. Then no time can be held against another, and
// all are marked as `shared`. Throws Error (run) that names a file that cannot be read or written.
RunOutcome write_results(const ExperimentRecord& record, const PieceStore& pieces, const nlohmann::json& key,
                         const MemoryTaken& memory, const std::filesystem::path& folder,
                         const nlohmann::json& machines = nlohmann::json::array());

}  // namespace truescatter
