#pragma once

#include <cstddef>
#include <filesystem>
#include <list>
#include <string>

#include "core/image.h"

namespace truescatter {

// The pictures of one view. They wait until the experiment is through, for error maps share one range.
struct ViewMaps {
  struct Truth {
    std::string stem;  // of its files' names
    Image rgb;
    Image mass;
    Image fit_error = {};  // of the truth of a profile itself: that of its Gaussians less it; else empty
  };
  struct Run {
    std::string stem;
    Image exitance;
    Image error;          // against the headline
    Image profile_error;  // against the truth of the profile itself; empty without one
  };

  // What the assumptions of a ladder add, one after the other.
  struct Ladder {
    struct Step {
      std::string name;  // the rung's
      Image error;       // signed
    };
    std::string stem;
    std::list<Step> steps;
  };

  std::string name;
  Image irradiance;
  Image mask;      // skin
  Image measured;  // skin with mass enough to be measured
  Image albedo;    // what of it comes after the scattering; empty where nothing does
  std::list<Truth> truths;
  std::list<Run> runs;
  std::list<Ladder> ladders;
};

// The name of a step's picture.
std::string step_file(const std::string& ladder_stem, const std::string& rung);

// An exitance times what of the albedo comes after the scattering; as it is where that is empty.
Image textured(Image exitance, const Image& albedo);

// Where the colours of error maps end, for all that are compared with each other.
struct MapRanges {
  double errors;
  double ladder_steps;
};

// Writes every view's pictures into `folder`, in parallel: PNG for the eye and EXR with the numbers.
// `range`: the ends of the error maps' colours. `exposure`: what turns the brightest irradiance into white.
// Throws Error (run) that names the file that cannot be written.
void write_maps(const std::list<ViewMaps>& views, const std::filesystem::path& folder,
                const MapRanges& ranges, double exposure);

}  // namespace truescatter
