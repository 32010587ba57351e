#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"

namespace truescatter {

// What the silhouette metrics need to know about a picture (README, Definitions).
struct ContourInputs {
  const Image& mask;         // 1 on skin
  const Image& position;     // view space, mm, looking along -z; z = 0 where nothing is seen
  const Image& face_normal;  // view space
  double focal_px;           // pixels per unit of x/-z; the axis passes through the image's centre
};

enum class ContourClass : std::uint8_t {
  none,
  outer,       // skin beside the background
  inner_near,  // skin beside a separated pixel that lies farther away
  inner_far,   // skin beside a separated pixel that lies nearer
};

// Per pixel, row by row.
struct ContourMap {
  int width = 0;
  int height = 0;
  std::vector<ContourClass> contour;  // the pixel's own class
  std::vector<char> mask_edge;        // 1: skin beside non-skin on one continuous surface; never a silhouette
  std::vector<ContourClass> nearest;  // class of the nearest contour pixel, for skin; none if there is none
  std::vector<double> delta_mm;  // distance on screen to it, times depth over focal length; infinite if none

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

// Neighbours (of four) are separated if their depths differ by more than 4 times the step that either one's
// facet predicts and by more than 0.5 mm. The frame's border is no contour: what lies beyond is not known.
ContourMap find_contours(const ContourInputs& inputs);

}  // namespace truescatter
