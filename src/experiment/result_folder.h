#pragma once

#include <filesystem>
#include <vector>

namespace truescatter {

// Throws Error (input) if results may not go to `destination`: a file, a link that leads nowhere, the folder
// that the program runs in (or one that holds it), a mount point, or a folder with anything in it that `run`
// does not write. Writes nothing.
void check_destination(const std::filesystem::path& destination);

// Whether one of two folders is the other or lies in it, links followed.
bool overlap(const std::filesystem::path& a, const std::filesystem::path& b);

// Removes what runs into `destination` that were cut off have left beside it: of results that nobody will go
// on from.
void discard_leftovers(const std::filesystem::path& destination);

// The folder of the pieces that a run with `resume` would go on from; empty: there are none.
std::filesystem::path pieces_left_for(const std::filesystem::path& destination);

// A result folder that appears whole or not at all. All files are written to a temporary folder beside it,
// `.<name>.<process>.part`, which `publish` puts in its place; until then an earlier result stays as it is,
// and an object that goes without `publish` or `keep` takes the temporary folder with it. The temporary
// folder is locked (flock, by a file in it) as long as the object lives: one that is not is left over from a
// run that was cut off. If it has finished pieces (PieceStore), a run can go on from them; it stays until
// another run is published.
class ResultFolder {
 public:
  // Makes the temporary folder, or with `resume` takes over the left-over one of this destination whose
  // pieces are the latest. Before, left-over ones without pieces are removed (a complete result is put in its
  // place, if nothing is there), with a line on standard error for each. Throws Error: input as
  // check_destination, run if the folder cannot be made.
  explicit ResultFolder(const std::filesystem::path& destination, bool resume = false);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  // Where to write.
  const std::filesystem::path& working() const { return working_; }
  // Leaves the temporary folder where it is if this is not published.
  void keep() { kept_ = true; }
  // Puts the folder in its place and removes its pieces (which are the result of a part, and stay then), what
  // runs that were cut off have left, and the earlier result (keeps it beside, with a note, if somebody has
  // put other files there since the run began). Throws Error (run) if that fails; the earlier result is in
  // its place then.
  void publish(bool with_pieces = false);

 private:
  void make_parents();
  void take_over(const std::filesystem::path& left, int lock);
  void exchange();

  std::filesystem::path target_;   // absolute, links followed
  std::filesystem::path working_;  // beside it
  std::vector<std::filesystem::path> made_parents_;
  int lock_ = -1;
  bool published_ = false;
  bool kept_ = false;
};

}  // namespace truescatter
