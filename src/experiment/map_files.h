#pragma once

#include <filesystem>
#include <list>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/image_io.h"

namespace truescatter {

// The pictures of a result: EXR with the numbers as each piece of a run is finished, and PNG for the eye at
// the end, made from those, for error maps share one range. Whatever cannot be written is an Error (run) that
// names the file. Each file carries `origin` (see picture_origin).

// What is behind every error map of a view.
struct ViewImages {
  Image irradiance;
  Image mask;    // skin
  Image albedo;  // what of it comes after the scattering; empty where nothing does
};
void write_view_maps(const std::filesystem::path& exr, const ViewImages& view, const ImageTexts& origin);
ViewImages read_view_maps(const std::filesystem::path& exr);

// The plain R, G, B is the truth. `fit_error`: of the truth of a profile itself, that of its Gaussians less
// it; else empty.
struct TruthMaps {
  const Image& rgb;
  const Image& mass;
  const Image& irradiance;
  const Image& mask;
  const Image& fit_error;
  const Image& composite;  // of the display, linear; empty without one
};
void write_truth_maps(const std::filesystem::path& exr, const TruthMaps& truth, const ImageTexts& origin);

// The plain R, G, B is the exitance.
struct RunMaps {
  const Image& exitance;
  const Image& error;  // against the headline
  const Image& mask;
  const Image& profile_error;  // against the truth of the profile itself; empty without one
  const Image& composite;      // of the display, linear; empty without one
  const Image& visible;        // FLIP between it and the truth's, one channel
};
void write_run_maps(const std::filesystem::path& exr, const RunMaps& run, const ImageTexts& origin);

// What an assumption of a ladder adds.
struct LadderStep {
  std::string name;  // the rung's
  Image error;       // signed
};
void write_ladder_maps(const std::filesystem::path& exr, const Image& mask,
                       const std::list<LadderStep>& steps, const ImageTexts& origin);

// The names of a truth's or a run's composite, and of a run's FLIP against the truth's.
std::string composite_file(const std::string& stem);
std::string visible_file(const std::string& stem);

// The name of a step's picture.
std::string step_file(const std::string& ladder_stem, const std::string& rung);

// An exitance times what of the albedo comes after the scattering; as it is where that is empty.
Image textured(Image exitance, const Image& albedo);

// Where the colours of error maps end, for all that are compared with each other.
struct MapRanges {
  double errors;
  double ladder_steps;
};

// Where the colours of FLIP maps end: one range for all, so that experiments can be compared. 0.2 is plain to
// see.
inline constexpr double kVisibleRange = 0.2;

// What of a view has pictures, by the stems of the files' names.
struct ViewPictures {
  std::string name;
  std::filesystem::path images;                  // of write_view_maps
  double exposure;                               // what turns the brightest irradiance into white
  std::vector<std::string> truths = {};          // of Gaussians
  std::vector<std::string> profile_truths = {};  // of profiles themselves
  std::vector<std::string> runs = {};
  struct Ladder {
    std::string stem;
    std::vector<std::string> steps;  // names of rungs
  };
  std::vector<Ladder> ladders = {};
  bool composites = false;  // there are some, of truths of Gaussians and of runs
};

// Writes the PNGs of a view into `maps`, in parallel, out of the EXRs that are there. Error maps show the
// skin that is measured under every profile: where each truth of Gaussians has mass enough.
void write_map_pictures(const ViewPictures& view, const std::filesystem::path& maps, const MapRanges& ranges,
                        const ImageTexts& origin);

}  // namespace truescatter
