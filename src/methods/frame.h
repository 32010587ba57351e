#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/image.h"
#include "gpu/framebuffer.h"
#include "gpu/program.h"
#include "gpu/texture.h"
#include "irradiance/light_fields.h"
#include "irradiance/shading_mesh.h"
#include "methods/light_view.h"
#include "scene/camera.h"

namespace truescatter {

// The shading mesh on the GPU, corner by corner (three vertices a triangle, none shared): attributes
// 0 position (world, mm), 1 face normal, 2 interpolated normal, 3 irradiance, 4 uv, 5 skin (0 or 1),
// 6 transmits (0 or 1), 7 the character's number, from 1.
//
// With the light fields of the mesh, its irradiance is there in parts too, which sum to it: one for each
// field, and a last one of what these leave, if there is any. Without fields: that last one alone.
class SurfaceBuffers {
 public:
  SurfaceBuffers(const gpu::Context& context, const ShadingMesh& shading,
                 const std::vector<LightField>& lights = {});
  ~SurfaceBuffers();
  SurfaceBuffers(const SurfaceBuffers&) = delete;
  SurfaceBuffers& operator=(const SurfaceBuffers&) = delete;

  void draw() const;
  // A scene's characters share one UV map: what lays them out in it draws one at a time (from 0).
  void draw_character(std::size_t character) const;
  std::size_t character_count() const { return first_vertices_.size() - 1; }
  std::size_t part_count() const { return parts_.size(); }
  // Where the light of a part comes from, as it sees a character alone; null: from more than one place, or
  // from everywhere.
  const LightView* part_light(std::size_t part, std::size_t character) const {
    return parts_[part].lights.empty() ? nullptr : &parts_[part].lights[character];
  }
  // As draw_character(), with attribute 3 the part's irradiance.
  void draw_part(std::size_t part, std::size_t character) const;
  bool has_uvs() const { return has_uvs_; }
  // Square root of the skin's area in mm^2 over its area in UV: mm per UV unit, on average. 0 without UVs.
  double mean_mm_per_uv_unit() const { return mean_mm_per_uv_unit_; }

 private:
  struct Part {
    std::vector<LightView> lights;  // one as each character is seen
    unsigned vertex_array;
    unsigned irradiance;  // a buffer; 0: the whole irradiance
  };
  unsigned make_vertex_array() const;
  void draw(unsigned vertex_array, std::size_t character) const;
  void add_part(std::vector<LightView> lights, const CornerIrradiance& irradiance);

  const gpu::Context& context_;
  unsigned vertex_array_ = 0;
  unsigned buffer_ = 0;
  std::vector<Part> parts_;
  std::vector<int> first_vertices_;  // of each character, and the end
  bool has_uvs_ = false;
  double mean_mm_per_uv_unit_ = 0.0;
};

// One rendered view: what every method gets (README, What it does). All textures are of the camera's size,
// sampled at pixel centres, without antialiasing; where nothing is seen they are 0.
struct Frame {
  Camera camera;
  Mat4d view;                // world to view space
  Mat4d projection;          // view to clip space; holds the whole mesh
  gpu::Texture position;     // rgb: view-space position, mm; a: 1 where a surface is seen
  gpu::Texture face_normal;  // rgb: the facet's unit normal, view space (for areas)
  gpu::Texture normal;       // rgb: the interpolated unit normal, view space (for K, d' and lighting)
  gpu::Texture irradiance;   // rgb: I; a: 1 on skin
  gpu::Texture uv;           // rg
  gpu::Texture surface_id;   // r: shading triangle + 1 (0: nothing), g, b: barycentrics 1 and 2 as float bits
  // r: the character's number from 1 on skin, 0 elsewhere; not valid in a scene of one character.
  gpu::Texture character = {};
};

Frame render_frame(const gpu::Context& context, const SurfaceBuffers& surface, const ShadingMesh& shading,
                   const Camera& camera);

// The point of the shading mesh behind a pixel.
struct PixelSurface {
  int triangle = -1;  // -1: nothing is seen
  Vec3d barycentric = Vec3d::Zero();
};

// The frame's contents on the host, row 0 at the top.
struct FrameImages {
  Image position;                     // 3 channels, view space, mm
  Image face_normal;                  // 3
  Image normal;                       // 3
  Image irradiance;                   // 3
  Image mask;                         // 1: 1 on skin
  std::vector<PixelSurface> surface;  // row by row

  const PixelSurface& surface_at(int x, int y) const {
    return surface[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width()) +
                   static_cast<std::size_t>(x)];
  }
};

FrameImages read_frame(const gpu::Context& context, const Frame& frame);

// Median distance along the view axis of the skin pixels, mm; 0 without skin in view.
double median_skin_depth_mm(const FrameImages& images);

}  // namespace truescatter
