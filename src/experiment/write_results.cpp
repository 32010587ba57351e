#include "experiment/write_results.h"

#include "core/file.h"
#include "experiment/map_files.h"
#include "experiment/provenance.h"
#include "experiment/result_json.h"
#include "experiment/results.h"

namespace truescatter {

using nlohmann::json;

RunOutcome write_results(const ExperimentSpec& spec, const std::vector<ScenePlan>& scenes,
                         const PieceStore& pieces, const json& key, const MemoryTaken& memory,
                         const std::filesystem::path& folder) {
  json results = join_pieces(spec, scenes, pieces);
  results["schema"] = kResultsSchema;
  const MapRanges ranges = common_ranges(results);
  const std::vector<ViewPictures> first = pictures_of(scenes.front(), pieces);
  results["maps"] = {{"range", ranges.errors},
                     {"ladder_range", ranges.ladder_steps},
                     {"quantity", "luminance"},
                     {"exposure", first.front().exposure}};
  if (spec.composite) results["maps"]["visible_range"] = kVisibleRange;
  results["provenance"] = key;
  results["provenance"]["finished_utc"] = now_utc();
  results["provenance"]["memory"] = {{"peak_bytes", memory.peak_bytes}, {"limit_bytes", memory.limit_bytes}};
  const std::vector<std::string> exceeded = exceeded_thresholds(results, spec.thresholds);
  results["exceeded"] = exceeded;
  const ImageTexts origin = picture_origin(key);
  for (const ScenePlan& scene : scenes) {
    for (const ViewPictures& view : pictures_of(scene, pieces))
      write_map_pictures(view, pieces.maps(), ranges, origin);
  }
  write_text_file(folder / kResolvedFile, to_toml(spec));
  write_text_file(folder / "results.csv", results_csv(results));
  write_text_file(folder / "results.json", results.dump(1) + "\n");
  return {exceeded};
}

}  // namespace truescatter
