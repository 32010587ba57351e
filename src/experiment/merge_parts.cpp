#include "experiment/merge_parts.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/content_hash.h"
#include "core/error.h"
#include "core/file.h"
#include "core/parallel.h"

namespace truescatter {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// That the parts have the pieces of the experiment, each once.
void check_pieces(const std::vector<PartResult>& parts) {
  std::map<std::string, const PartResult*> has;
  for (const PartResult& part : parts) {
    for (const std::string& id : part.pieces) {
      const auto [found, is_new] = has.try_emplace(id, &part);
      if (!is_new)
        throw_input_error({(part.folder / kPartFile).string()}, "lists piece {}, as {} does", id,
                          found->second->folder.string());
    }
  }
  for (const ExperimentRecord::Scene& scene : parts.front().record.scenes) {
    for (const Piece& piece : scene.pieces) {
      if (has.erase(piece.id()) == 0)
        throw_input_error({}, "no part lists piece {} of this experiment", piece.id());
    }
  }
  if (!has.empty())
    throw_input_error({(has.begin()->second->folder / kPartFile).string()},
                      "lists {}, which is no piece of this experiment", has.begin()->first);
}

void check_files(const PartResult& part) {
  for (const std::string& id : part.pieces) {
    if (part.files.count("pieces/" + id + ".json") == 0)
      throw_input_error({(part.folder / kPartFile).string()}, "lists piece {} but no file of it", id);
  }
  std::vector<std::pair<std::string, std::string>> files(part.files.begin(), part.files.end());
  parallel_for(files.size(), [&](std::size_t i) {
    const fs::path file = part.folder / files[i].first;
    if (!fs::exists(file))
      throw_input_error({file.string()}, "this file of part {} is missing", part.part.str());
    if (hash_of_file(file) != files[i].second)
      throw_input_error({file.string()}, "is not the file that {} says", kPartFile);
  });
}

void copy_files(const fs::path& from, const fs::path& to) {
  if (!fs::is_directory(from)) return;
  make_folder(to);
  for (const fs::directory_entry& entry : fs::directory_iterator(from)) {
    const fs::path copy = to / entry.path().filename();
    if (entry.path().filename() == PieceStore::kKeyFile) continue;  // each part has its own
    std::error_code failure;
    fs::copy_file(entry.path(), copy, failure);
    if (failure)
      throw_run_error("{}: cannot be copied to {}: {}", entry.path().string(), copy.string(),
                      failure.message());
  }
}

}  // namespace

RunOutcome merge_parts(const std::vector<PartResult>& parts, const fs::path& folder) {
  check_pieces(parts);
  for (const PartResult& part : parts) check_files(part);

  const PieceStore pieces(folder);
  MemoryTaken memory = parts.front().work.memory;
  std::vector<json> keys;
  for (const PartResult& part : parts) {
    for (const char* kind : kPartFolders) copy_files(part.folder / kind, folder / kind);
    memory.peak_bytes = std::max(memory.peak_bytes, part.work.memory.peak_bytes);
    keys.push_back(part.key);
  }
  json key = parts.front().key;
  for (const char* own : {"part", "more_machines", "times_shared"}) key.erase(own);
  pieces.set_key(key);
  return write_results(parts.front().record, pieces, key, memory, folder, machines_of(keys));
}

}  // namespace truescatter
