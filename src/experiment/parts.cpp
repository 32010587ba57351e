#include "experiment/parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/content_hash.h"
#include "core/error.h"
#include "core/file.h"
#include "core/parse_number.h"
#include "experiment/input_files.h"
#include "experiment/piece_cost.h"
#include "experiment/provenance.h"
#include "experiment/result_folder.h"

namespace truescatter {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// Pieces that one part computes.
struct Group {
  std::string view;  // with its scene's place in the experiment
  std::vector<std::string> ids;
  double cost_s = 0.0;
};

// Whether ladders, of which every view and profile has one, read the pictures of methods' runs.
bool ladders_read_pictures(const Plan& plan) {
  return std::any_of(plan.ladders.begin(), plan.ladders.end(), [](const LadderSpec& ladder) {
    return std::any_of(ladder.rungs.begin(), ladder.rungs.end(),
                       [](const LadderSpec::Rung& rung) { return rung.truth.empty(); });
  });
}

// Each piece by itself, but for those of a view and profile where a ladder reads runs' pictures.
std::vector<Group> groups_of(const std::vector<ScenePlan>& scenes) {
  std::vector<Group> groups;
  for (std::size_t scene = 0; scene < scenes.size(); ++scene) {
    const auto& [spec, plan] = scenes[scene];
    const bool together = ladders_read_pictures(plan);
    std::string open_group;
    for (const Piece& piece : pieces_of(spec, plan)) {
      const std::string name = together && !piece.profile.empty() ? piece.view + "/" + piece.profile : "";
      if (name.empty() || name != open_group) groups.push_back({fmt::format("{} {}", scene, piece.view), {}});
      open_group = name;
      groups.back().ids.push_back(piece.id());
      groups.back().cost_s += piece_cost_s(spec, plan, piece);
    }
  }
  return groups;
}

// The groups' costs summed up, in millionths of the whole: integers, which are the same on every machine.
std::vector<std::int64_t> costs_before(const std::vector<Group>& groups) {
  double all_s = 0.0;
  for (const Group& group : groups) all_s += group.cost_s;
  std::vector<std::int64_t> before = {0};
  for (const Group& group : groups)
    before.push_back(before.back() + std::llround(1e6 * group.cost_s / all_s));
  return before;
}

// The first group of each part, and behind the last one's the number of groups. A group belongs to the part
// in whose equal share of the whole cost its middle lies.
std::vector<std::size_t> equal_cuts(const std::vector<std::int64_t>& before, int count) {
  std::vector<std::size_t> cuts = {0};
  const std::size_t groups = before.size() - 1;
  for (int part = 1; part < count; ++part) {
    std::size_t cut = cuts.back();
    while (cut < groups && (before[cut] + before[cut + 1]) * count < 2 * part * before.back()) ++cut;
    cuts.push_back(cut);
  }
  cuts.push_back(groups);
  return cuts;
}

// A view that a cut divides is drawn and lit by two parts. So each cut moves to the next place between two
// views, if that makes neither part beside it dearer than the dearest of all was, give or take a fiftieth:
// costs are not known better.
std::vector<std::size_t> cuts_between_views(const std::vector<Group>& groups, int count) {
  const std::vector<std::int64_t> before = costs_before(groups);
  std::vector<std::size_t> cuts = equal_cuts(before, count);
  std::int64_t dearest = 0;
  for (std::size_t part = 0; part + 1 < cuts.size(); ++part)
    dearest = std::max(dearest, before[cuts[part + 1]] - before[cuts[part]]);
  const std::int64_t limit = dearest + dearest / 50;
  for (std::size_t k = 1; k + 1 < cuts.size(); ++k) {
    const auto moves = [&](std::size_t to) {
      const bool divides = to > 0 && to < groups.size() && groups[to - 1].view == groups[to].view;
      return !divides && before[to] - before[cuts[k - 1]] <= limit &&
             before[cuts[k + 1]] - before[to] <= limit;
    };
    for (std::size_t away = 0; away < groups.size(); ++away) {
      const bool back = cuts[k] >= cuts[k - 1] + away && moves(cuts[k] - away);
      if (!back && !(cuts[k] + away <= cuts[k + 1] && moves(cuts[k] + away))) continue;
      cuts[k] = back ? cuts[k] - away : cuts[k] + away;
      break;
    }
  }
  return cuts;
}

// The pieces of this part (`own`), or of all others.
std::set<std::string> ids_where(const std::vector<ScenePlan>& scenes, const ExperimentPart& part, bool own) {
  const std::vector<Group> groups = groups_of(scenes);
  const std::vector<std::size_t> cuts = cuts_between_views(groups, part.count);
  const std::size_t index = static_cast<std::size_t>(part.index);
  std::set<std::string> ids;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const bool is_own = cuts[index - 1] <= i && i < cuts[index];
    if (is_own == own) ids.insert(groups[i].ids.begin(), groups[i].ids.end());
  }
  return ids;
}

// What must be the same for parts to be joined: nodes of one cluster differ in name and number of cores.
json joined_key(json key) {
  for (const char* own : {"part", "machine", "more_machines", "rasteriser_threads", "times_shared"})
    key.erase(own);
  return key;
}

// Every file that a part's result has beside part.json and the resolved experiment.
std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const char* kind : kPartFolders) {
    if (!fs::is_directory(folder / kind)) continue;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder / kind)) {
      const fs::path name = entry.path().filename();
      if (name != PieceStore::kKeyFile) files[(kind / name).string()] = hash_of_file(entry.path());
    }
  }
  return files;
}

std::string duration_text(double seconds) {
  if (seconds < 60.0) return fmt::format("{:.2g} s", std::max(seconds, 0.1));
  if (seconds < 5400.0) return fmt::format("{:.0f} min", seconds / 60.0);
  return fmt::format("{:.1f} h", seconds / 3600.0);
}

// What a result is of, whatever it was computed on.
json subject_of(const ExperimentSpec& experiment) {
  json subject = program_provenance();
  subject["experiment"] = experiment_hash(experiment);
  subject["inputs"] = input_hashes(experiment);
  return subject;
}

// The entries of a key that `like` has.
json entries_like(const json& like, const json& key) {
  json entries = json::object();
  for (const auto& [name, value] : like.items()) entries[name] = key.value(name, json());
  return entries;
}

// Whether pieces in this folder are of this program, experiment and inputs.
bool is_of(const fs::path& pieces, const ExperimentSpec& experiment) {
  const json key = json::parse(read_text_file(pieces / PieceStore::kKeyFile), nullptr, false);
  const json subject = subject_of(experiment);
  return key.is_object() && entries_like(subject, key) == subject;
}

std::string names_of(const std::vector<int>& parts) {
  return fmt::format("part{} {}", parts.size() == 1 ? "" : "s", fmt::join(parts, ", "));
}

void check_same(const PartResult& first, const PartResult& other) {
  const SourceLocation where{(other.folder / kPartFile).string()};
  if (other.part.count != first.part.count) {
    throw_input_error(where, "is part {}, and {} is part {}: not of one division", other.part.str(),
                      first.folder.string(), first.part.str());
  }
  const std::string difference = part_difference(first.key, other.key);
  if (!difference.empty()) {
    throw_input_error(where, "cannot be joined with {}: {}", first.folder.string(), difference);
  }
}

// Another program would put its own name under what it did not compute.
void check_program(const PartResult& part) {
  const json now = program_provenance();
  if (const std::string difference = provenance_difference(entries_like(now, part.key), now);
      !difference.empty())
    throw_input_error({(part.folder / kPartFile).string()},
                      "was computed by another program, which alone can merge it: {}", difference);
}

void check_complete(const std::vector<PartResult>& parts) {
  std::vector<int> missing;
  for (int index = 1; index <= parts.front().part.count; ++index) {
    std::vector<std::string> folders;
    for (const PartResult& part : parts) {
      if (part.part.index == index) folders.push_back(part.folder.string());
    }
    if (folders.empty()) missing.push_back(index);
    if (folders.size() > 1)
      throw_input_error({}, "part {}/{} is there more than once: {}", index, parts.front().part.count,
                        fmt::join(folders, ", "));
  }
  if (!missing.empty())
    throw_input_error({}, "{} of {} {} missing", names_of(missing), parts.front().part.count,
                      missing.size() == 1 ? "is" : "are");
}

}  // namespace

std::string ExperimentPart::str() const { return fmt::format("{}/{}", index, count); }

ExperimentPart parse_part(const std::string& text) {
  const SourceLocation where{"--part"};
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos)
    throw_input_error(where, "\"{}\": a part is INDEX/COUNT, for example 2/8", text);
  const ExperimentPart part{parse_integer(text.substr(0, slash), where, "a part's index"),
                            parse_integer(text.substr(slash + 1), where, "a number of parts")};
  if (part.count < 1 || part.index < 1 || part.index > part.count)
    throw_input_error(where, "\"{}\": a part's index is from 1 to the number of parts", text);
  return part;
}

std::set<std::string> pieces_of_part(const std::vector<ScenePlan>& scenes, const ExperimentPart& part) {
  return ids_where(scenes, part, true);
}

std::set<std::string> pieces_elsewhere(const std::vector<ScenePlan>& scenes, const ExperimentPart& part) {
  return ids_where(scenes, part, false);
}

std::string describe_pieces(const ExperimentSpec& experiment, const std::vector<ScenePlan>& scenes,
                            const std::optional<ExperimentPart>& part, bool finished,
                            const fs::path& destination) {
  const std::set<std::string> own = part ? pieces_of_part(scenes, *part) : std::set<std::string>();
  const fs::path left = pieces_left_for(destination);
  const bool usable = !left.empty() && is_of(left, experiment);
  const auto reason = [&](const Piece& piece) {
    if (finished) return "finished in the part that is there, --resume leaves it";
    if (left.empty() || !fs::exists(left / (piece.id() + ".json"))) return "nothing of it is kept";
    return usable ? "finished by a run that was cut off, --resume takes it over"
                  : "finished by a run of another program, experiment or input, which --resume cannot use";
  };
  std::string text;
  double own_s = 0.0;
  double all_s = 0.0;
  for (const auto& [spec, plan] : scenes) {
    for (const Piece& piece : pieces_of(spec, plan)) {
      const double cost_s = piece_cost_s(spec, plan, piece);
      all_s += cost_s;
      if (part && own.count(piece.id()) == 0) continue;
      own_s += cost_s;
      text += fmt::format("piece {}: about {}; {}\n", piece.id(), duration_text(cost_s), reason(piece));
    }
  }
  text += fmt::format("pieces: about {}{}, and what their scenes and truths share\n", duration_text(own_s),
                      part ? fmt::format(" of {} in all {} parts", duration_text(all_s), part->count) : "");
  return text;
}

void write_part(const fs::path& folder, const ExperimentPart& part, const std::set<std::string>& pieces,
                const ExperimentRecord& record, const json& key, const PartWork& work) {
  const json written = {
      {"schema", kPartSchema},
      {"part", {{"index", part.index}, {"of", part.count}}},
      {"pieces", pieces},
      {"record", record_json(record)},
      {"files", files_of(folder)},
      {"provenance", key},
      {"truths", {{"computed", work.truths_computed}, {"found", work.truths_found}}},
      {"memory", {{"peak_bytes", work.memory.peak_bytes}, {"limit_bytes", work.memory.limit_bytes}}}};
  write_text_file(folder / kPartFile, written.dump(1) + "\n");
}

PartResult read_part(const fs::path& folder) {
  const fs::path file = folder / kPartFile;
  if (!fs::is_directory(folder)) throw_input_error({folder.string()}, "no such folder");
  if (!fs::exists(file))
    throw_input_error({folder.string()}, "has no {}: it is no result of `run --part`", kPartFile);
  const json read = json::parse(read_text_file(file), nullptr, false);
  try {
    if (read.at("schema") == kPartSchema) {
      return {folder,
              {read.at("part").at("index").get<int>(), read.at("part").at("of").get<int>()},
              read.at("pieces").get<std::vector<std::string>>(),
              read_record(read.at("record")),
              read.at("files").get<std::map<std::string, std::string>>(),
              read.at("provenance"),
              {{read.at("memory").at("peak_bytes").get<std::uint64_t>(),
                read.at("memory").at("limit_bytes").get<std::uint64_t>()},
               read.at("truths").at("computed").get<std::size_t>(),
               read.at("truths").at("found").get<std::size_t>()}};
    }
  } catch (const json::exception& problem) {
    throw_input_error({file.string()}, "is not what `run --part` writes: {}", problem.what());
  }
  throw_input_error({file.string()}, "is not what this version of `run --part` writes, \"{}\"", kPartSchema);
}

std::vector<PartResult> read_parts(const std::vector<fs::path>& folders) {
  std::vector<PartResult> parts;
  for (const fs::path& folder : folders) parts.push_back(read_part(folder));
  for (const PartResult& part : parts) check_same(parts.front(), part);
  check_complete(parts);
  check_program(parts.front());  // the others are of the same
  std::sort(parts.begin(), parts.end(),
            [](const PartResult& a, const PartResult& b) { return a.part.index < b.part.index; });
  return parts;
}

std::string part_difference(const json& before, const json& now) {
  return provenance_difference(joined_key(before), joined_key(now));
}

json machines_of(const std::vector<json>& keys) {
  json machines = json::array();
  const auto add = [&](json machine) {
    machine.erase("jobs");
    machine.erase("system");
    if (std::find(machines.begin(), machines.end(), machine) == machines.end()) machines.push_back(machine);
  };
  for (const json& key : keys) {
    add(key.value("machine", json::object()));
    for (const json& more : key.value("more_machines", json::array())) add(more);
  }
  return machines;
}

json with_machines_of(const json& key, const json& other) {
  json machines = machines_of({key, other});
  json joined = key;
  machines.erase(machines.begin());
  if (!machines.empty()) joined["more_machines"] = machines;
  return joined;
}

bool is_finished_part(const fs::path& folder, const PartRequest& request, const ExperimentSpec& spec) {
  if (!fs::exists(folder / kPartFile)) return false;
  json now = subject_of(spec);
  now["exports"] = request.exports;
  now["gl_context"] = request.gl_context;
  now["times_shared"] = request.times_shared;
  try {
    const PartResult there = read_part(folder);
    const bool complete = std::all_of(there.files.begin(), there.files.end(),
                                      [&](const auto& file) { return fs::exists(folder / file.first); });
    return complete && there.part == request.part && entries_like(now, there.key) == now;
  } catch (const Error& error) {
    fmt::print(stderr, "note: {}; computing the part again\n", error.what());
    return false;
  }
}

void check_kind_of_result(const fs::path& folder, bool is_part) {
  const bool holds_part = fs::exists(folder / kPartFile);
  const bool holds_whole = fs::exists(folder / "results.json");
  if (is_part && holds_whole && !holds_part)
    throw_input_error({folder.string()}, "holds a whole result, which a part does not replace");
  if (!is_part && holds_part)
    throw_input_error({folder.string()},
                      "holds a part of an experiment, which a whole result does not replace");
}

}  // namespace truescatter
