#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "experiment/write_results.h"

namespace truescatter {

// One share of an experiment's pieces, `index` of `count` from 1: what `run --part index/count` computes.
struct ExperimentPart {
  int index = 1;
  int count = 1;

  std::string str() const;  // "2/8"
  bool operator==(const ExperimentPart&) const = default;
};

// "2/8". Throws Error (input) at --part for anything else, or an index that is not from 1 to the count.
ExperimentPart parse_part(const std::string& text);

// The ids of a part's pieces. In the order of the results the pieces are cut into runs of about equal cost
// (piece_cost_s), so that a part needs few of the scenes and views, and between views wherever that makes the
// dearest part hardly dearer; the same on every machine. A ladder out of methods' pictures stays with their
// runs. Of more parts than there are pieces some have none.
std::set<std::string> pieces_of_part(const std::vector<ScenePlan>& scenes, const ExperimentPart& part);
// Of all other parts.
std::set<std::string> pieces_elsewhere(const std::vector<ScenePlan>& scenes, const ExperimentPart& part);

// For --dry-run: each piece, about what it costs, and why it would run: nothing of it is kept, or a run into
// `destination` that was cut off has finished it, which --resume takes over if it is of the same program,
// experiment and inputs. Of a part: its pieces alone, and what the others have; `finished`: it is done.
std::string describe_pieces(const ExperimentSpec& experiment, const std::vector<ScenePlan>& scenes,
                            const std::optional<ExperimentPart>& part, bool finished,
                            const std::filesystem::path& destination);

// A part's result is a folder with its pieces and maps, and part.json, which says of which part and under
// which provenance they were computed, what all of them are of, and what each file holds.
struct PartWork {
  MemoryTaken memory;
  std::size_t truths_computed;  // Gaussians, of the view's pixels each; that were stored in the cache
  std::size_t truths_found;     // in the cache
};
inline constexpr const char* kPartFile = "part.json";
inline constexpr std::array<const char*, 4> kPartFolders = {"pieces", "maps", "inputs", "passes"};
inline constexpr const char* kPartSchema = "truescatter-part-2";
void write_part(const std::filesystem::path& folder, const ExperimentPart& part,
                const std::set<std::string>& pieces, const ExperimentRecord& record,
                const nlohmann::json& key, const PartWork& work);

// What part.json says. Throws Error (input) that names the file if it is not there or says anything else.
struct PartResult {
  std::filesystem::path folder;
  ExperimentPart part;
  std::vector<std::string> pieces;
  ExperimentRecord record;
  std::map<std::string, std::string> files;  // hash_of_file, by their paths in the folder
  nlohmann::json key;                        // provenance
  PartWork work;
};
PartResult read_part(const std::filesystem::path& folder);

// The parts of one experiment, in their order. Throws Error (input) that names folders and parts where one is
// missing or there twice, or where they were computed by another program than each other's or this one, of
// another experiment or of other inputs. Machines may differ, renderers may not.
std::vector<PartResult> read_parts(const std::vector<std::filesystem::path>& folders);

// Why what was computed under `before` cannot be joined with what is computed under `now`; empty: it can.
// Unlike provenance_difference this takes no notice of machines.
std::string part_difference(const nlohmann::json& before, const nlohmann::json& now);

// `key`, and the machines of another one.
nlohmann::json with_machines_of(const nlohmann::json& key, const nlohmann::json& other);
// The machines that computed what lies under these keys, each once, without what no time depends on.
nlohmann::json machines_of(const std::vector<nlohmann::json>& keys);

// Whether `folder` holds this part, all of it, finished by this program of this experiment, these inputs and
// these exports, in the same kind of OpenGL context and its times as fit for charts: nothing is left to do.
struct PartRequest {
  ExperimentPart part;
  nlohmann::json exports;
  std::string gl_context;
  bool times_shared = false;
};
bool is_finished_part(const std::filesystem::path& folder, const PartRequest& request,
                      const ExperimentSpec& spec);

// Throws Error (input) that names the folder if a part would replace a whole result there, or the reverse.
void check_kind_of_result(const std::filesystem::path& folder, bool is_part);

}  // namespace truescatter
