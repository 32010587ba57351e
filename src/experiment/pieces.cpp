#include "experiment/pieces.h"

#include <fmt/format.h>

#include <cstdlib>
#include <utility>

#include "core/error.h"
#include "core/file.h"

namespace truescatter {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* kFolder = "pieces";
constexpr const char* kKey = PieceStore::kKeyFile;

std::string name_of(Piece::Kind kind) {
  switch (kind) {
    case Piece::Kind::view:
      return "view";
    case Piece::Kind::truth:
      return "truth";
    case Piece::Kind::run:
      return "run";
    case Piece::Kind::ladder:
      return "ladder";
    case Piece::Kind::stability:
      return "stability";
    case Piece::Kind::widths:
      return "widths";
  }
  std::abort();
}

json read_json(const fs::path& file) {
  json read = json::parse(read_text_file(file), nullptr, false);
  if (read.is_discarded()) throw_run_error("{}: this finished piece of a run is no JSON", file.string());
  return read;
}

}  // namespace

std::string Piece::stem() const {
  const std::string suffix = kind == Kind::truth ? "truth" : kind == Kind::ladder ? "ladder-" + name : name;
  std::string stem = view;
  for (const std::string& part : {profile, suffix}) stem += part.empty() ? "" : "." + part;
  return stem;
}

std::string Piece::id() const { return name_of(kind) + "." + stem(); }

std::string profile_truth_stem(const Piece& truth) { return truth.stem() + ".profile"; }

std::vector<Piece> pieces_of(const ExperimentSpec& point, const Plan& plan) {
  std::vector<Piece> pieces;
  for (const ViewSpec& view : point.views) {
    pieces.push_back({Piece::Kind::view, view.name});
    for (const Profile& profile : plan.profiles) {
      pieces.push_back({Piece::Kind::truth, view.name, profile.name});
      for (const PlannedMethod& method : plan.methods)
        pieces.push_back({Piece::Kind::run, view.name, profile.name, method.label});
      for (const LadderSpec& ladder : plan.ladders)
        pieces.push_back({Piece::Kind::ladder, view.name, profile.name, ladder.name});
    }
    if (point.stability && point.stability->of(view)) pieces.push_back({Piece::Kind::stability, view.name});
  }
  if (!plan.ladders.empty()) pieces.push_back({Piece::Kind::widths, point.views.front().name});
  return pieces;
}

PieceStore::PieceStore(const fs::path& working, std::set<std::string> elsewhere)
    : working_(working), folder_(working / kFolder), elsewhere_(std::move(elsewhere)) {
  make_folder(folder_);
  make_folder(maps());
}

bool PieceStore::has(const Piece& piece) const {
  return is_elsewhere(piece) || fs::exists(folder_ / (piece.id() + ".json"));
}

json PieceStore::read(const Piece& piece) const { return read_json(folder_ / (piece.id() + ".json")); }

void PieceStore::keep(const Piece& piece, const json& finished) const {
  write_text_file(folder_ / (piece.id() + ".json"), finished.dump(1) + "\n");
}

fs::path PieceStore::picture(const Piece& piece) const { return folder_ / (piece.id() + ".exr"); }

fs::path PieceStore::maps() const { return working_ / "maps"; }

std::optional<json> PieceStore::key() const {
  if (!fs::exists(folder_ / kKey)) return std::nullopt;
  return read_json(folder_ / kKey);
}

void PieceStore::set_key(const json& key) const { write_text_file(folder_ / kKey, key.dump(1) + "\n"); }

void PieceStore::clear() const {
  remove_pieces(working_);
  make_folder(folder_);
}

bool has_pieces(const fs::path& working) { return fs::exists(working / kFolder / kKey); }

void remove_pieces(const fs::path& working) {
  const fs::path folder = working / kFolder;
  std::error_code failure;
  // Without its key the folder is no longer one of pieces, however far removing it comes.
  fs::remove(folder / kKey, failure);
  if (!failure) fs::remove_all(folder, failure);
  if (failure) throw_run_error("{}: cannot remove this folder: {}", folder.string(), failure.message());
}

}  // namespace truescatter
