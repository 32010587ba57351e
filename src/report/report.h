#pragma once

#include <filesystem>

namespace truescatter {

// Writes `folder`/report.html from the results.json and the maps that lie there, and from nothing else. The
// page carries its styles, scripts and pictures in itself: it opens from disk, without a network.
// Throws Error (input) if the folder holds no results of a schema that this version knows.
void write_report(const std::filesystem::path& folder);

}  // namespace truescatter
