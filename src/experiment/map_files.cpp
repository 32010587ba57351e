#include "experiment/map_files.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "core/image_io.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "experiment/view_truth.h"
#include "metrics/map_picture.h"

namespace truescatter {
namespace {

namespace fs = std::filesystem;

Image grey(const Image& values) {
  Image image(values.width(), values.height(), 3);
  for (std::size_t i = 0; i < image.data().size(); ++i) image.data()[i] = values.data()[i / 3];
  return image;
}

// Makes PNGs of a view out of its EXRs; each job reads one of them.
class PictureJobs {
 public:
  PictureJobs(const ViewPictures& view, fs::path maps, const MapRanges& ranges, const ImageTexts& origin)
      : view_(view),
        maps_(std::move(maps)),
        ranges_(ranges),
        origin_(origin),
        images_(read_view_maps(view.images)),
        measured_(images_.mask) {
    for (const std::string& truth : view.truths)
      measured_ = measured_mask(std::move(measured_), layer_of(read(truth), "mass"));
    add_jobs();
  }

  void run() const {
    Progress progress("maps of view " + view_.name, jobs_.size());
    const double bytes_each = static_cast<double>(measured_.pixel_count()) * kPictureJobBytes;
    const JobLimit limit(jobs_within(bytes_each, job_count()));
    parallel_for(jobs_.size(), [&](std::size_t i) {
      jobs_[i]();
      progress.advance();
    });
  }

 private:
  LayeredImage read(const std::string& stem) const { return read_layered_image(maps_ / (stem + ".exr")); }

  // What is shown of an exitance: with the albedo after the scattering.
  void write_exitance(const std::string& stem, const LayeredImage& exr) const {
    write_png(maps_ / (stem + ".png"),
              display_picture(textured(layer_of(exr, ""), images_.albedo), view_.exposure), origin_);
  }

  // What a display shows is in the file.
  void write_composite(const std::string& stem, const LayeredImage& exr) const {
    write_png(maps_ / composite_file(stem), display_picture(layer_of(exr, "composite"), 1.0), origin_);
  }

  void write_map(const std::string& stem, const Image& error, MapKind kind, const std::string& title) const {
    const std::string file = stem + (kind == MapKind::magnitude ? ".abs.png" : ".signed.png");
    write_png(maps_ / file, map_picture(error, measured_, kind, ranges_.errors, title), origin_);
  }

  void add_jobs() {
    jobs_.emplace_back([this] {
      write_png(maps_ / (view_.name + ".irradiance.png"), display_picture(images_.irradiance, view_.exposure),
                origin_);
    });
    for (const std::string& truth : view_.truths) {
      jobs_.emplace_back([this, &truth] {
        const LayeredImage exr = read(truth);
        write_exitance(truth, exr);
        if (view_.composites) write_composite(truth, exr);
      });
    }
    for (const std::string& truth : view_.profile_truths) {
      jobs_.emplace_back([this, &truth] {
        const LayeredImage exr = read(truth);
        write_exitance(truth, exr);
        write_map(truth, layer_of(exr, "fit_error"), MapKind::signed_error, "FIT ERROR LUMINANCE");
      });
    }
    for (const std::string& run : view_.runs) {
      jobs_.emplace_back([this, &run] {
        const LayeredImage exr = read(run);
        const Image error = layer_of(exr, "error");
        write_exitance(run, exr);
        write_map(run, error, MapKind::magnitude, "|ERROR| LUMINANCE");
        write_map(run, error, MapKind::signed_error, "ERROR LUMINANCE");
        if (!view_.composites) return;
        write_composite(run, exr);
        write_png(maps_ / visible_file(run),
                  map_picture(grey(layer_of(exr, "visible")), measured_, MapKind::magnitude, kVisibleRange,
                              "FLIP OF PICTURES"),
                  origin_);
      });
    }
    for (const ViewPictures::Ladder& ladder : view_.ladders) {
      jobs_.emplace_back([this, &ladder] {
        const LayeredImage exr = read(ladder.stem);
        for (const std::string& step : ladder.steps) {
          write_png(maps_ / step_file(ladder.stem, step),
                    map_picture(layer_of(exr, step), measured_, MapKind::signed_error, ranges_.ladder_steps,
                                "STEP LUMINANCE"),
                    origin_);
        }
      });
    }
  }

  const ViewPictures& view_;
  fs::path maps_;
  MapRanges ranges_;
  const ImageTexts& origin_;
  ViewImages images_;
  Image measured_;
  std::vector<std::function<void()>> jobs_;
};

}  // namespace

void write_view_maps(const fs::path& exr, const ViewImages& view, const ImageTexts& origin) {
  std::vector<ExrLayer> layers = {{"irradiance", &view.irradiance}, {"mask", &view.mask}};
  if (!view.albedo.empty()) layers.push_back({"albedo", &view.albedo});
  write_exr(exr, layers, origin);
}

ViewImages read_view_maps(const fs::path& exr) {
  const LayeredImage view = read_layered_image(exr);
  const bool has_albedo = std::find(view.names.begin(), view.names.end(), "albedo.R") != view.names.end();
  return {layer_of(view, "irradiance"), layer_of(view, "mask"),
          has_albedo ? layer_of(view, "albedo") : Image()};
}

void write_truth_maps(const fs::path& exr, const TruthMaps& truth, const ImageTexts& origin) {
  std::vector<ExrLayer> layers = {
      {"", &truth.rgb}, {"mass", &truth.mass}, {"irradiance", &truth.irradiance}, {"mask", &truth.mask}};
  if (!truth.fit_error.empty()) layers.push_back({"fit_error", &truth.fit_error});
  if (!truth.composite.empty()) layers.push_back({"composite", &truth.composite});
  write_exr(exr, layers, origin);
}

void write_run_maps(const fs::path& exr, const RunMaps& run, const ImageTexts& origin) {
  std::vector<ExrLayer> layers = {{"", &run.exitance}, {"error", &run.error}, {"mask", &run.mask}};
  if (!run.profile_error.empty()) layers.push_back({"profile_error", &run.profile_error});
  if (!run.composite.empty()) {
    layers.push_back({"composite", &run.composite});
    layers.push_back({"visible", &run.visible});
  }
  write_exr(exr, layers, origin);
}

void write_ladder_maps(const fs::path& exr, const Image& mask, const std::list<LadderStep>& steps,
                       const ImageTexts& origin) {
  std::vector<ExrLayer> layers = {{"mask", &mask}};
  for (const LadderStep& step : steps) layers.push_back({step.name, &step.error});
  write_exr(exr, layers, origin);
}

Image textured(Image exitance, const Image& albedo) {
  for (std::size_t i = 0; i < albedo.data().size(); ++i) exitance.data()[i] *= albedo.data()[i];
  return exitance;
}

std::string composite_file(const std::string& stem) { return stem + ".composite.png"; }
std::string visible_file(const std::string& stem) { return stem + ".visible.png"; }

std::string step_file(const std::string& ladder_stem, const std::string& rung) {
  return ladder_stem + "." + rung + ".step.png";
}

void write_map_pictures(const ViewPictures& view, const fs::path& maps, const MapRanges& ranges,
                        const ImageTexts& origin) {
  PictureJobs(view, maps, ranges, origin).run();
}

}  // namespace truescatter
