#pragma once

#include <filesystem>
#include <string>

namespace truescatter {

// What is wrong with the lengths of the attributes in an EXR's header, in words: one that is longer than what
// is left of the file, or not as long as its type says; empty where nothing is, and for a file that is no
// EXR. OpenEXR (3.1) takes memory for a text, up to 2 GiB, before it looks whether the file has as much, and
// reads other values by their types, so that a wrong length makes it find attributes inside of others.
std::string wrong_exr_attribute(const std::filesystem::path& path);

}  // namespace truescatter
