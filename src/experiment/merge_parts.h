#pragma once

#include <filesystem>
#include <vector>

#include "experiment/parts.h"
#include "experiment/write_results.h"

namespace truescatter {

// Joins parts (read_parts) into one result in `folder`, which must be there: what a run that was not divided
// writes, byte for byte, timings apart. Pieces and pictures are copied; the parts stay. Throws Error: input
// where a part's files are not what its part.json says, run for the disk.
RunOutcome merge_parts(const std::vector<PartResult>& parts, const std::filesystem::path& folder);

}  // namespace truescatter
