#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "config/experiment_spec.h"
#include "experiment/plan.h"

namespace truescatter {

// What a run is made of: each piece is computed by itself, is kept when it is finished, and is joined with
// the others at the end.
struct Piece {
  enum class Kind {
    view,       // of every view: what it shows
    truth,      // of every view and profile: the truths, and what the Gaussians differ from the profile by
    run,        // of every view, profile and method
    ladder,     // of every view, profile and ladder, out of the runs' pictures
    stability,  // of a view, where it is asked for
    widths      // of every scene with ladders: the widths of the rungs' filters; `view` is the scene's first
  };
  Kind kind;
  std::string view;
  std::string profile = {};
  std::string name = {};  // a method's label, or a ladder's name

  // The piece's name, which tells it from all others of an experiment and never changes:
  // "run.front.skin.pscbf".
  std::string id() const;
  // What its pictures' names begin with: "front.skin.pscbf".
  std::string stem() const;
};

// Of the pictures of the truth of a profile itself, which a truth's piece has beside its own where there is
// one.
std::string profile_truth_stem(const Piece& truth);

// The pieces of one scene, those of its first view first, in the order of the results.
std::vector<Piece> pieces_of(const ExperimentSpec& point, const Plan& plan);

// Where the finished pieces of a run lie: <working>/pieces/<id>.json holds a piece's share of results.json,
// and the pictures that it was made with are in <working>/maps, in full precision. A piece is finished when
// its JSON is there, which is written last; all files appear whole. `key.json` says what the pieces belong
// to.
class PieceStore {
 public:
  static constexpr const char* kKeyFile = "key.json";

  // Makes the folder if it is not there. `elsewhere`: ids of pieces that are not this run's to compute, for
  // another part of the experiment does. Throws Error (run) if it cannot be made.
  explicit PieceStore(const std::filesystem::path& working, std::set<std::string> elsewhere = {});

  bool is_elsewhere(const Piece& piece) const { return elsewhere_.count(piece.id()) > 0; }
  // Whether nothing is left to do for it here: it is finished, or elsewhere.
  bool has(const Piece& piece) const;
  // Throws Error (run) that names the file if it is not there or is no JSON.
  nlohmann::json read(const Piece& piece) const;
  // Throws Error (run) that names the file if it cannot be written.
  void keep(const Piece& piece, const nlohmann::json& finished) const;

  // Pictures of `piece` that no result holds.
  std::filesystem::path picture(const Piece& piece) const;
  // The folder of those that a result holds.
  std::filesystem::path maps() const;

  // Null where the folder is new.
  std::optional<nlohmann::json> key() const;
  void set_key(const nlohmann::json& key) const;
  // Forgets all pieces. Throws Error (run) if they cannot be removed.
  void clear() const;

 private:
  std::filesystem::path working_;
  std::filesystem::path folder_;
  std::set<std::string> elsewhere_;
};

// Whether pieces lie in a run's working folder.
bool has_pieces(const std::filesystem::path& working);

// Removes them, but for the maps: what results are made of when they are there. Throws Error (run).
void remove_pieces(const std::filesystem::path& working);

}  // namespace truescatter
