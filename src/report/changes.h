#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace truescatter {

// What changed from one result folder to another, from their files alone:
//   schema, old, new    "truescatter-changes-1", the folders
//   provenance          {"commit": {"old", "new"}, ...}: what differs of version, commit, compiler, renderer,
//                       machine
//   experiment          {"truth.tolerance": {"old", "new"}, ...}: what differs of the resolved experiments,
//   as
//                       TOML text, null where one has no such key; null with a reason if a folder holds none
//   runs                [{scene, view, profile, label, metrics: {"rmse": {"old", "new", "change"}, ...}}]:
//                       those in both; change = (new - old) / |old|, null with a reason where there is none
//   only_old, only_new  [{scene, view, profile, label}]
// A run is known by the last part of its scene's path, view, profile and label: so results from a moved
// checkout match. Throws Error (input) that names the file: see read_results, and for two runs of one name.
nlohmann::json result_changes(const std::filesystem::path& old_folder,
                              const std::filesystem::path& new_folder);

// The same as a table for people.
std::string changes_text(const nlohmann::json& changes);

}  // namespace truescatter
