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
//   runs                [{scene, view, profile, label, changed: [names], metrics: {"rmse": {"old", "new",
//                       "change", "changed", "noise"}, ...}}]: those in both; change = (new - old) / |old|,
//                       null with a reason where there is none; changed: whether it is more than noise. For
//                       bias, MAE, RMSE, quantiles and maximum noise is the sum u of both truths'
//                       uncertainties, in units of irradiance; for rel_rmse u (1 + rel_rmse) / RMS of the
//                       truth; frame_ms has changed where the ranges of the repeats (old_range, new_range:
//                       [min, max]) do not overlap, null for fewer than two; all else has where it differs
//   only_old, only_new  [{scene, view, profile, label}]
// A run is known by the last part of its scene's path, view, profile and label: so results from a moved
// checkout match. Throws Error (input) that names the file: see read_results, and for two runs of one name.
nlohmann::json result_changes(const std::filesystem::path& old_folder,
                              const std::filesystem::path& new_folder);

// The same as a table for people.
std::string changes_text(const nlohmann::json& changes);

}  // namespace truescatter
