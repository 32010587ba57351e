#include "experiment/map_files.h"

#include <functional>
#include <utility>
#include <vector>

#include "core/image_io.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "metrics/map_picture.h"

namespace truescatter {
namespace {

using Job = std::function<void()>;

// What is shown of an exitance: with the albedo after the scattering.
Image rendered_picture(Image exitance, const Image& albedo, double exposure) {
  return display_picture(textured(std::move(exitance), albedo), exposure);
}

// What has to be written for one view; each job is one file.
void add_jobs(const ViewMaps& view, const std::filesystem::path& maps, const MapRanges& ranges,
              double exposure, std::vector<Job>& jobs) {
  const double range = ranges.errors;
  jobs.emplace_back([&view, maps, exposure] {
    write_png(maps / (view.name + ".irradiance.png"), display_picture(view.irradiance, exposure));
  });
  for (const ViewMaps::Truth& truth : view.truths) {
    jobs.emplace_back([&view, &truth, maps, exposure] {
      write_png(maps / (truth.stem + ".png"), rendered_picture(truth.rgb, view.albedo, exposure));
    });
    jobs.emplace_back([&view, &truth, maps] {
      std::vector<ExrLayer> layers = {
          {"", &truth.rgb}, {"mass", &truth.mass}, {"irradiance", &view.irradiance}, {"mask", &view.mask}};
      if (!truth.fit_error.empty()) layers.push_back({"fit_error", &truth.fit_error});
      write_exr(maps / (truth.stem + ".exr"), layers);
    });
    if (truth.fit_error.empty()) continue;
    jobs.emplace_back([&view, &truth, maps, range] {
      write_png(
          maps / (truth.stem + ".signed.png"),
          map_picture(truth.fit_error, view.measured, MapKind::signed_error, range, "FIT ERROR LUMINANCE"));
    });
  }
  for (const ViewMaps::Run& run : view.runs) {
    jobs.emplace_back([&view, &run, maps, exposure] {
      write_png(maps / (run.stem + ".png"), rendered_picture(run.exitance, view.albedo, exposure));
    });
    jobs.emplace_back([&view, &run, maps, range] {
      write_png(maps / (run.stem + ".abs.png"),
                map_picture(run.error, view.measured, MapKind::magnitude, range, "|ERROR| LUMINANCE"));
    });
    jobs.emplace_back([&view, &run, maps, range] {
      write_png(maps / (run.stem + ".signed.png"),
                map_picture(run.error, view.measured, MapKind::signed_error, range, "ERROR LUMINANCE"));
    });
    jobs.emplace_back([&view, &run, maps] {
      std::vector<ExrLayer> layers = {{"", &run.exitance}, {"error", &run.error}, {"mask", &view.mask}};
      if (!run.profile_error.empty()) layers.push_back({"profile_error", &run.profile_error});
      write_exr(maps / (run.stem + ".exr"), layers);
    });
  }
  for (const ViewMaps::Ladder& ladder : view.ladders) {
    for (const ViewMaps::Ladder::Step& step : ladder.steps) {
      jobs.emplace_back([&view, &ladder, &step, maps, ranges] {
        write_png(maps / step_file(ladder.stem, step.name),
                  map_picture(step.error, view.measured, MapKind::signed_error, ranges.ladder_steps,
                              "STEP LUMINANCE"));
      });
    }
    jobs.emplace_back([&view, &ladder, maps] {
      std::vector<ExrLayer> layers = {{"mask", &view.mask}};
      for (const ViewMaps::Ladder::Step& step : ladder.steps) layers.push_back({step.name, &step.error});
      write_exr(maps / (ladder.stem + ".exr"), layers);
    });
  }
}

}  // namespace

Image textured(Image exitance, const Image& albedo) {
  for (std::size_t i = 0; i < albedo.data().size(); ++i) exitance.data()[i] *= albedo.data()[i];
  return exitance;
}

std::string step_file(const std::string& ladder_stem, const std::string& rung) {
  return ladder_stem + "." + rung + ".step.png";
}

void write_maps(const std::list<ViewMaps>& views, const std::filesystem::path& folder,
                const MapRanges& ranges, double exposure) {
  std::vector<Job> jobs;
  for (const ViewMaps& view : views) add_jobs(view, folder, ranges, exposure, jobs);
  Progress progress("maps", jobs.size());
  parallel_for(jobs.size(), [&](std::size_t i) {
    jobs[i]();
    progress.advance();
  });
}

}  // namespace truescatter
