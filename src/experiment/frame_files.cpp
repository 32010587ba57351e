#include "experiment/frame_files.h"

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/image_io.h"
#include "experiment/result_json.h"

namespace truescatter {
namespace {

using nlohmann::json;

Image depth_of(const FrameImages& images) {
  Image depth(images.mask.width(), images.mask.height(), 1);
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) depth.at(x, y, 0) = std::abs(images.position.at(x, y, 2));
  }
  return depth;
}

json matrix_json(const Mat4d& m) {
  json rows = json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({m(r, 0), m(r, 1), m(r, 2), m(r, 3)});
  return rows;
}

json camera_json(const std::string& view, const Camera& camera, double median_depth_mm) {
  return {{"view", view},
          {"width_px", camera.width_px},
          {"height_px", camera.height_px},
          {"focal_px", camera.focal_px()},
          {"eye_mm", vector_json(camera.eye_mm)},
          {"target_mm", vector_json(camera.target_mm)},
          {"world_to_view", matrix_json(camera.view_matrix())},
          {"median_skin_depth_mm", median_depth_mm},
          {"conventions",
           "Row 0 is the top. View space: x right, y up, z towards the viewer, in mm, the eye at the origin. "
           "A point "
           "is seen at column width_px / 2 - focal_px x / z and row height_px / 2 + focal_px y / z, pixel "
           "centres at "
           "halves; one sample a pixel. Values are linear; where nothing is seen all are 0."},
          {"layers",
           {{"position", "X, Y, Z: view space, mm"},
            {"face_normal", "X, Y, Z: the facet's unit normal, view space (areas)"},
            {"normal", "X, Y, Z: the interpolated unit normal, view space (lighting, K)"},
            {"irradiance", "R, G, B: irradiance; what leaves without scattering"},
            {"mask", "1 on skin"},
            {"depth", "-z, mm"}}}};
}

}  // namespace

void write_frame(const std::filesystem::path& folder, const std::string& view, const Camera& camera,
                 const FrameImages& images, const ImageTexts& origin) {
  const Image depth = depth_of(images);
  write_exr(folder / (view + ".exr"),
            {{"position", &images.position, true},
             {"face_normal", &images.face_normal, true},
             {"normal", &images.normal, true},
             {"irradiance", &images.irradiance},
             {"mask", &images.mask},
             {"depth", &depth}},
            origin);
  json about = camera_json(view, camera, median_skin_depth_mm(images));
  about["origin"] = origin;
  write_text_file(folder / (view + ".json"), about.dump(1) + "\n");
}

}  // namespace truescatter
