#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace truescatter {

// A name beside `path` for a file that is renamed to `path` once it is whole; unique per process.
std::filesystem::path temporary_sibling(const std::filesystem::path& path);

// Whether a file's name is one that temporary_sibling gives.
bool is_temporary_name(std::string_view name);

// Renames a whole temporary to `path`. Where that fails, removes the temporary and throws Error (run) that
// names `path`.
void commit_temporary(const std::filesystem::path& temporary, const std::filesystem::path& path);

// Gives two files or folders of one file system each other's name: at once where the file system can, else by
// exchange_names_in_steps. Throws Error (run) that names `b`; then both have the names that they had.
void exchange_names(const std::filesystem::path& a, const std::filesystem::path& b,
                    const std::filesystem::path& spare);

// The same in three renames, by a third name that is free; a process that is killed between them leaves the
// earlier `b` under that name.
void exchange_names_in_steps(const std::filesystem::path& a, const std::filesystem::path& b,
                             const std::filesystem::path& spare);

// Makes a folder, and those above it, where they are missing. Throws Error (run) that names it.
void make_folder(const std::filesystem::path& folder);

// Writes a whole text file through a temporary and a rename, so that it appears whole or not at all.
// Throws Error (run) that names the file.
void write_text_file(const std::filesystem::path& path, std::string_view text);

// Reads a whole file. Throws Error (input) that names the file.
std::string read_text_file(const std::filesystem::path& path);

// Replaces each ${NAME} by the environment variable's value. An unset variable is an Error (input).
std::string expand_environment(const std::string& text);

}  // namespace truescatter
