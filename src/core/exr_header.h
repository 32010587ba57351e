#pragma once

#include <filesystem>
#include <string>

namespace truescatter {

// What an EXR's header asks for that its file cannot hold: an attribute longer than what is left of the file,
// in words; empty where there is none, and for a file that is no EXR. OpenEXR (3.1) takes memory for an
// attribute, up to 2 GiB, before it looks whether the file has as much.
std::string oversized_exr_attribute(const std::filesystem::path& path);

}  // namespace truescatter
