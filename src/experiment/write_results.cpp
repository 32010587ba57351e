#include "experiment/write_results.h"

#include "core/file.h"
#include "experiment/map_files.h"
#include "experiment/provenance.h"
#include "experiment/results.h"

namespace truescatter {

using nlohmann::json;

namespace {

void mark_times_as_shared(json& runs) {
  for (json& run : runs) {
    if (run.contains("cost") && run["cost"].contains("frame_ms")) run["cost"]["frame_ms"]["shared"] = true;
  }
}

}  // namespace

RunOutcome write_results(const ExperimentRecord& record, const PieceStore& pieces, const json& key,
                         const MemoryTaken& memory, const std::filesystem::path& folder,
                         const json& machines) {
  json results = join_pieces(record, pieces);
  if (machines.size() > 1) mark_times_as_shared(results["runs"]);
  results["schema"] = kResultsSchema;
  const MapRanges ranges = common_ranges(results);
  const std::vector<ViewPictures> views = pictures_of(record, pieces);
  results["maps"] = {{"range", ranges.errors},
                     {"ladder_range", ranges.ladder_steps},
                     {"quantity", "luminance"},
                     {"exposure", views.front().exposure}};
  if (!record.composite.is_null()) results["maps"]["visible_range"] = kVisibleRange;
  results["provenance"] = key;
  if (machines.size() > 1) results["provenance"]["machines"] = machines;
  results["provenance"]["finished_utc"] = now_utc();
  results["provenance"]["memory"] = {{"peak_bytes", memory.peak_bytes}, {"limit_bytes", memory.limit_bytes}};
  const std::vector<std::string> exceeded = exceeded_thresholds(results, record.thresholds);
  results["exceeded"] = exceeded;
  const ImageTexts origin = picture_origin(key);
  for (const ViewPictures& view : views) write_map_pictures(view, pieces.maps(), ranges, origin);
  write_text_file(folder / kResolvedFile, record.resolved);
  write_text_file(folder / "results.csv", results_csv(results));
  write_text_file(folder / "results.json", results.dump(1) + "\n");
  return {exceeded};
}

}  // namespace truescatter
