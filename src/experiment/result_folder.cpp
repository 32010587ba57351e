#include "experiment/result_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "experiment/parts.h"
#include "experiment/pieces.h"

namespace truescatter {
namespace {

namespace fs = std::filesystem;

// The folders of a result, with the kinds of files that they hold.
const std::map<std::string, std::vector<std::string>, std::less<>> kFolders = {{"maps", {".png", ".exr"}},
                                                                               {"inputs", {".exr", ".json"}},
                                                                               {"passes", {".png", ".exr"}},
                                                                               {"pieces", {".json", ".exr"}}};
constexpr const char* kLockFile = ".lock";  // as long as a process works in the folder
constexpr std::array<std::string_view, 6> kFiles = {"report.html", "results.json", "results.csv",
                                                    kResolvedFile, kPartFile,      kLockFile};

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::error_code failure;
  std::vector<fs::path> entries;
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure))
    entries.push_back(it->path());
  if (failure) throw_input_error({folder.string()}, "cannot look into this folder: {}", failure.message());
  std::sort(entries.begin(), entries.end());
  return entries;
}

bool is_plain_file(const fs::path& path) { return fs::is_regular_file(fs::symlink_status(path)); }
bool is_plain_folder(const fs::path& path) { return fs::is_directory(fs::symlink_status(path)); }

// An entry that `run` does not write, if there is one. Recognised by name: this decides what may be removed.
std::optional<fs::path> foreign_entry(const fs::path& folder) {
  for (const fs::path& entry : entries_of(folder)) {
    const std::string name = entry.filename().string();
    if (is_plain_file(entry)) {
      if (std::find(kFiles.begin(), kFiles.end(), name) == kFiles.end() && !is_temporary_name(name))
        return entry;
    } else if (!is_plain_folder(entry) || kFolders.count(name) == 0) {
      return entry;
    }
  }
  for (const auto& [name, kinds] : kFolders) {
    if (!is_plain_folder(folder / name)) continue;
    for (const fs::path& entry : entries_of(folder / name)) {
      const bool known = std::find(kinds.begin(), kinds.end(), entry.extension().string()) != kinds.end();
      if (!is_plain_file(entry) || !known) return entry;
    }
  }
  return std::nullopt;
}

bool has_schema(const fs::path& file, std::string_view start) {
  if (!is_plain_file(file)) return false;
  const nlohmann::json results = nlohmann::json::parse(read_text_file(file), nullptr, false);
  if (!results.is_object()) return false;
  const auto schema = results.find("schema");
  return schema != results.end() && schema->is_string() && schema->get<std::string>().starts_with(start);
}

// Whether a folder's results.json or part.json says that `run` wrote it, in this version or another.
bool has_results(const fs::path& folder) {
  return has_schema(folder / "results.json", "truescatter-results-") ||
         has_schema(folder / kPartFile, "truescatter-part-");
}

// The folder itself: absolute, without a slash at its end, and where a link leads.
fs::path resolved(const fs::path& destination) {
  fs::path path = fs::absolute(destination).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  std::error_code failure;
  const fs::path real = fs::weakly_canonical(path, failure);
  return failure ? path : real;
}

bool holds(const fs::path& folder, const fs::path& path) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

bool is_mount_point(const fs::path& folder) {
  struct stat own {};
  struct stat parent {};
  return stat(folder.c_str(), &own) == 0 && stat(folder.parent_path().c_str(), &parent) == 0 &&
         own.st_dev != parent.st_dev;
}

// Locks a folder that no process holds; -1 if one does, or if it cannot be opened. By a file in it: locks of
// folders themselves are each machine's own on a file system that several share (NFS).
int lock_folder(const fs::path& folder) {
  const int descriptor = open((folder / kLockFile).c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor < 0 || flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
  close(descriptor);
  return -1;
}

fs::path beside(const fs::path& target, std::string_view ending) {
  return target.parent_path() / fmt::format(".{}.{}.{}", target.filename().string(), getpid(), ending);
}

// Whether `name` is one that `beside` gives for this target in some process.
bool is_beside_name(const std::string& name, const fs::path& target) {
  const std::string start = fmt::format(".{}.", target.filename().string());
  if (!name.starts_with(start)) return false;
  const std::string rest = name.substr(start.size());
  const std::size_t dot = rest.find('.');
  return dot != std::string::npos && dot > 0 &&
         std::all_of(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(dot),
                     [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }) &&
         (rest.substr(dot) == ".part" || rest.substr(dot) == ".old");
}

void note(const fs::path& path, const std::string& text) {
  fmt::print(stderr, "note: {}: {}\n", path.string(), text);
}

// What a run that was cut off has left beside a target, locked.
struct Leftover {
  fs::path folder;
  int lock;
};

// Those that no process works in.
std::vector<Leftover> leftovers_of(const fs::path& target) {
  std::vector<Leftover> found;
  if (!is_plain_folder(target.parent_path())) return found;
  for (const fs::path& left : entries_of(target.parent_path())) {
    if (!is_beside_name(left.filename().string(), target) || !is_plain_folder(left)) continue;
    if (const int lock = lock_folder(left); lock >= 0) found.push_back({left, lock});
  }
  return found;
}

// Files that were being written when a run was cut off.
void remove_temporaries(const fs::path& folder) {
  for (const auto& [name, kinds] : kFolders) {
    if (!is_plain_folder(folder / name)) continue;
    for (const fs::path& entry : entries_of(folder / name)) {
      if (is_temporary_name(entry.filename().string())) fs::remove(entry);
    }
  }
}

// One that can be put in its place; with pieces it is what a run goes on from.
bool is_whole_result(const fs::path& folder) { return has_results(folder) && !has_pieces(folder); }

// Puts a whole result in its place, if nothing is there, and removes what is of no use. Returns whether
// something is left that a run can go on from.
bool clear_leftover(const fs::path& left, const fs::path& target) {
  std::error_code failure;
  if (foreign_entry(left)) {
    note(left, "left by a run that was cut off; it holds other files, so it stays");
  } else if (is_whole_result(left) && !fs::exists(fs::symlink_status(target))) {
    fs::rename(left, target, failure);
    note(left, failure ? "cannot be put in its place: " + failure.message()
                       : "left by a run that was cut off; put in its place");
  } else if (has_pieces(left)) {
    return true;
  } else {
    fs::remove_all(left, failure);
    note(left, failure ? "left by a run that was cut off; cannot be removed: " + failure.message()
                       : "left by a run that was cut off; removed");
  }
  return false;
}

// The leftover that was worked in last, which the caller has the lock of.
std::optional<Leftover> latest_pieces(const fs::path& target) {
  std::optional<Leftover> latest;
  for (const Leftover& left : leftovers_of(target)) {
    const bool usable = clear_leftover(left.folder, target);
    const auto time = [](const Leftover& of) { return fs::last_write_time(of.folder / "pieces"); };
    if (usable && (!latest || time(left) > time(*latest))) {
      if (latest) close(latest->lock);
      latest = left;
    } else {
      close(left.lock);
    }
  }
  return latest;
}

}  // namespace

void check_destination(const fs::path& destination) {
  const SourceLocation where{destination.string()};
  const fs::path target = resolved(destination);
  const fs::file_status status = fs::symlink_status(target);
  if (fs::is_symlink(status)) throw_input_error(where, "is a link that leads nowhere");
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status))
    throw_input_error(where, "is a file; the results need a folder, which `run` makes");
  if (holds(target, fs::current_path())) {
    throw_input_error(
        where, "the program runs in this folder; results replace a folder as a whole, so name another");
  }
  if (is_mount_point(target)) {
    throw_input_error(where,
                      "is a mount point; results replace a folder as a whole, so name a folder inside it");
  }
  if (const std::optional<fs::path> foreign = foreign_entry(target)) {
    throw_input_error(
        where,
        "holds '{}', which is no result of truescatter; results replace a folder as a whole, so "
        "name a new folder, an empty one, or one that `run` has written",
        foreign->lexically_relative(target).string());
  }
  if (!fs::is_empty(target) && !has_results(target)) {
    throw_input_error(where,
                      "is not empty, and no results.json says that truescatter has written it; name another "
                      "folder, or empty this one");
  }
}

bool overlap(const fs::path& a, const fs::path& b) {
  return holds(resolved(a), resolved(b)) || holds(resolved(b), resolved(a));
}

void discard_leftovers(const fs::path& destination) {
  for (const Leftover& left : leftovers_of(resolved(destination))) {
    std::error_code failure;
    if (!foreign_entry(left.folder)) fs::remove_all(left.folder, failure);
    if (failure) note(left.folder, "left by a run that was cut off; cannot be removed: " + failure.message());
    close(left.lock);
  }
}

fs::path pieces_left_for(const fs::path& destination) {
  fs::path latest;
  for (const Leftover& left : leftovers_of(resolved(destination))) {
    const fs::path pieces = left.folder / "pieces";
    if (has_pieces(left.folder) &&
        (latest.empty() || fs::last_write_time(pieces) > fs::last_write_time(latest)))
      latest = pieces;
    close(left.lock);
  }
  return latest;
}

ResultFolder::ResultFolder(const fs::path& destination, bool resume)
    : target_(resolved(destination)), working_(beside(target_, "part")) {
  check_destination(destination);
  const std::optional<Leftover> left = latest_pieces(target_);
  if (left && resume) {
    take_over(left->folder, left->lock);
    return;
  }
  if (left) {
    note(left->folder,
         "left by a run that was cut off; --resume goes on from it, and it is removed when "
         "this run is through");
    close(left->lock);
  } else if (resume) {
    note(target_, "no run that was cut off has left anything to go on from; starting from the beginning");
  }
  make_parents();
  std::error_code failure;
  const bool made = fs::create_directory(working_, failure);
  if (made) lock_ = lock_folder(working_);
  if (lock_ >= 0) return;
  std::error_code ignored;
  if (made) fs::remove(working_, ignored);
  for (auto parent = made_parents_.rbegin(); parent != made_parents_.rend(); ++parent)
    fs::remove(*parent, ignored);
  const std::string reason = failure ? failure.message()
                             : made  ? "it cannot be locked"
                                     : working_.string() + " is in the way";
  throw_run_error("{}: cannot make a folder beside it for the results: {}", destination.string(), reason);
}

// The lock belongs to the folder under any name.
void ResultFolder::take_over(const fs::path& left, int lock) {
  lock_ = lock;
  kept_ = true;
  std::error_code failure;
  fs::rename(left, working_, failure);
  if (failure) working_ = left;
  remove_temporaries(working_);
}

void ResultFolder::make_parents() {
  std::vector<fs::path> missing;
  for (fs::path at = target_.parent_path(); !fs::exists(at) && at != at.parent_path(); at = at.parent_path())
    missing.push_back(at);
  std::error_code ignored;  // making the folder itself says what is wrong
  for (auto parent = missing.rbegin(); parent != missing.rend(); ++parent) {
    if (fs::create_directory(*parent, ignored)) made_parents_.push_back(*parent);
  }
}

ResultFolder::~ResultFolder() {
  std::error_code ignored;
  if (!published_ && !kept_) {
    fs::remove_all(working_, ignored);
    for (auto parent = made_parents_.rbegin(); parent != made_parents_.rend(); ++parent)
      fs::remove(*parent, ignored);
  }
  close(lock_);
}

void ResultFolder::publish(bool with_pieces) {
  exchange();
  // The result is whole; before, the folder would have been anybody's.
  std::error_code ignored;
  fs::remove(target_ / kLockFile, ignored);
  // Now, not before: what cannot be put in its place can be resumed.
  try {
    if (!with_pieces) remove_pieces(target_);
  } catch (const Error& error) {
    note(target_, error.what());
  }
  for (const Leftover& left : leftovers_of(target_)) {
    std::error_code failure;
    if (clear_leftover(left.folder, target_)) fs::remove_all(left.folder, failure);
    if (failure) note(left.folder, "cannot be removed: " + failure.message());
    close(left.lock);
  }
}

void ResultFolder::exchange() {
  std::error_code failure;
  if (!fs::exists(fs::symlink_status(target_))) {
    fs::rename(working_, target_, failure);
    if (failure)
      throw_run_error("{}: cannot give the results this name: {}", target_.string(), failure.message());
    published_ = true;
    return;
  }
  exchange_names(working_, target_, beside(target_, "old"));
  published_ = true;
  // The earlier result has the temporary name now.
  if (is_plain_folder(working_) && !foreign_entry(working_)) {
    fs::remove_all(working_, failure);
    if (failure) note(working_, "the earlier result cannot be removed: " + failure.message());
    return;
  }
  const fs::path kept =
      target_.parent_path() / fmt::format("{}.kept.{}", target_.filename().string(), getpid());
  fs::rename(working_, kept, failure);
  note(failure ? working_ : kept, "kept: something else was put there during the run");
}

}  // namespace truescatter
