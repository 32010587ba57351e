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

  std::string name;
  Image irradiance;
  Image mask;      // skin
  Image measured;  // skin with mass enough to be measured
  Image albedo;    // what of it comes after the scattering; empty where nothing does
  std::list<Truth> truths;
  std::list<Run> runs;
};

// An exitance times what of the albedo comes after the scattering; as it is where that is empty.
Image textured(Image exitance, const Image& albedo);

// Writes every view's pictures into `folder`, in parallel: PNG for the eye and EXR with the numbers.
// `range`: the end of the error maps' colours. `exposure`: what turns the brightest irradiance into white.
// Throws Error (run) that names the file that cannot be written.
void write_maps(const std::list<ViewMaps>& views, const std::filesystem::path& folder, double range,
                double exposure);

}  // namespace truescatter
