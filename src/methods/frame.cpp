#include "methods/frame.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "methods/shader_files.h"

namespace truescatter {
namespace {

struct CornerVertex {
  Vec3f position_mm;
  Vec3f face_normal;
  Vec3f normal;
  Vec3f irradiance;
  Vec2f uv;
  float skin;
  float transmits;
  float character;
};
static_assert(sizeof(CornerVertex) == 17 * sizeof(float));

std::vector<CornerVertex> corner_vertices(const ShadingMesh& shading) {
  std::vector<CornerVertex> vertices;
  vertices.reserve(3 * shading.triangles.size());
  std::size_t character = 0;  // from 1
  for (const ShadingTriangle& triangle : shading.triangles) {
    while (character < shading.character_starts.size() &&
           shading.character_starts[character] == vertices.size() / 3)
      ++character;
    const Vec3d a = shading.corner(triangle, 0);
    const Vec3d cross = (shading.corner(triangle, 1) - a).cross(shading.corner(triangle, 2) - a);
    const Vec3f face_normal = cross.stableNormalized().cast<float>();
    for (std::size_t c = 0; c < 3; ++c) {
      vertices.push_back({shading.corner(triangle, c).cast<float>(), face_normal,
                          triangle.normals[c].cast<float>(), triangle.irradiance[c].cast<float>(),
                          triangle.uvs[c].cast<float>(), triangle.skin ? 1.0F : 0.0F,
                          triangle.transmits ? 1.0F : 0.0F, static_cast<float>(character)});
    }
  }
  return vertices;
}

std::vector<int> first_vertices_of(const ShadingMesh& shading) {
  std::vector<int> first;
  for (const std::size_t start : shading.character_starts) first.push_back(static_cast<int>(3 * start));
  first.push_back(static_cast<int>(3 * shading.triangles.size()));
  return first;
}

double mean_mm_per_uv_unit_of(const ShadingMesh& shading) {
  double area_mm2 = 0.0;
  double area_uv = 0.0;
  for (const ShadingTriangle& triangle : shading.triangles) {
    if (!triangle.skin) continue;
    const Vec3d a = shading.corner(triangle, 0);
    area_mm2 += 0.5 * (shading.corner(triangle, 1) - a).cross(shading.corner(triangle, 2) - a).norm();
    const Vec2d u = triangle.uvs[1] - triangle.uvs[0];
    const Vec2d v = triangle.uvs[2] - triangle.uvs[0];
    area_uv += 0.5 * std::abs(u.x() * v.y() - u.y() * v.x());
  }
  return area_uv > 0.0 ? std::sqrt(area_mm2 / area_uv) : 0.0;
}

// Whether nothing is left but rounding of sums of double precision.
bool is_dark(const CornerIrradiance& irradiance) {
  return std::all_of(irradiance.begin(), irradiance.end(), [](const std::array<Vec3d, 3>& corners) {
    return std::all_of(corners.begin(), corners.end(),
                       [](const Vec3d& value) { return value.cwiseAbs().maxCoeff() < 1e-9; });
  });
}

// The smallest depth interval that holds the mesh, with a margin; the part in front of the camera.
std::pair<double, double> depth_range_mm(const ShadingMesh& shading, const Mat4d& view) {
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = 0.0;
  for (const Vec3d& p : shading.positions_mm) {
    const double depth = -(view.row(2).head<3>().dot(p) + view(2, 3));
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  farthest = std::max(1.01 * farthest, 1.0);
  return {std::max(0.99 * nearest, 1e-4 * farthest), farthest};
}

}  // namespace

SurfaceBuffers::SurfaceBuffers(const gpu::Context& context, const ShadingMesh& shading,
                               const std::vector<LightField>& lights)
    : context_(context),
      first_vertices_(first_vertices_of(shading)),
      has_uvs_(shading.has_uvs),
      mean_mm_per_uv_unit_(shading.has_uvs ? mean_mm_per_uv_unit_of(shading) : 0.0) {
  const std::vector<CornerVertex> vertices = corner_vertices(shading);
  const gpu::GlFunctions& gl = context.gl();
  gl.GenBuffers(1, &buffer_);
  gl.BindBuffer(GL_ARRAY_BUFFER, buffer_);
  gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(CornerVertex)),
                vertices.data(), GL_STATIC_DRAW);
  vertex_array_ = make_vertex_array();
  for (const LightField& field : lights) {
    std::vector<LightView> views;
    for (std::size_t i = 0; i < character_count(); ++i) views.push_back(light_view(shading, i, field.light));
    add_part(std::move(views), field.irradiance);
  }
  if (lights.empty()) {
    add_part({}, {});
  } else if (const CornerIrradiance rest = rest_of_irradiance(shading, lights); !is_dark(rest)) {
    add_part({}, rest);
  }
  context.check("uploading the surface");
}

SurfaceBuffers::~SurfaceBuffers() {
  const gpu::GlFunctions& gl = context_.gl();
  for (const Part& part : parts_) {
    if (part.irradiance == 0) continue;
    gl.DeleteBuffers(1, &part.irradiance);
    gl.DeleteVertexArrays(1, &part.vertex_array);
  }
  gl.DeleteBuffers(1, &buffer_);
  gl.DeleteVertexArrays(1, &vertex_array_);
}

// All attributes out of the one buffer.
unsigned SurfaceBuffers::make_vertex_array() const {
  const gpu::GlFunctions& gl = context_.gl();
  unsigned vertex_array = 0;
  gl.GenVertexArrays(1, &vertex_array);
  gl.BindVertexArray(vertex_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, buffer_);
  std::size_t offset = 0;
  unsigned attribute = 0;
  for (const int components : {3, 3, 3, 3, 2, 1, 1, 1}) {
    gl.EnableVertexAttribArray(attribute);
    gl.VertexAttribPointer(attribute, components, GL_FLOAT, GL_FALSE, sizeof(CornerVertex),
                           reinterpret_cast<const void*>(offset));
    offset += static_cast<std::size_t>(components) * sizeof(float);
    ++attribute;
  }
  return vertex_array;
}

void SurfaceBuffers::add_part(std::vector<LightView> lights, const CornerIrradiance& irradiance) {
  if (irradiance.empty()) {
    parts_.push_back({std::move(lights), vertex_array_, 0});
    return;
  }
  std::vector<Vec3f> corners;
  corners.reserve(3 * irradiance.size());
  for (const std::array<Vec3d, 3>& triangle : irradiance) {
    for (const Vec3d& value : triangle) corners.push_back(value.cast<float>());
  }
  const gpu::GlFunctions& gl = context_.gl();
  Part part{std::move(lights), make_vertex_array(), 0};
  gl.GenBuffers(1, &part.irradiance);
  gl.BindBuffer(GL_ARRAY_BUFFER, part.irradiance);
  gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(Vec3f)), corners.data(),
                GL_STATIC_DRAW);
  gl.VertexAttribPointer(3, 3, GL_FLOAT, GL_FALSE, sizeof(Vec3f), nullptr);
  parts_.push_back(std::move(part));
}

void SurfaceBuffers::draw() const {
  context_.gl().BindVertexArray(vertex_array_);
  context_.gl().DrawArrays(GL_TRIANGLES, 0, first_vertices_.back());
}

void SurfaceBuffers::draw_character(std::size_t character) const { draw(vertex_array_, character); }

void SurfaceBuffers::draw_part(std::size_t part, std::size_t character) const {
  draw(parts_[part].vertex_array, character);
}

void SurfaceBuffers::draw(unsigned vertex_array, std::size_t character) const {
  const int first = first_vertices_[character];
  context_.gl().BindVertexArray(vertex_array);
  context_.gl().DrawArrays(GL_TRIANGLES, first, first_vertices_[character + 1] - first);
}

Frame render_frame(const gpu::Context& context, const SurfaceBuffers& surface, const ShadingMesh& shading,
                   const Camera& camera) {
  const int w = camera.width_px;
  const int h = camera.height_px;
  const Mat4d view = camera.view_matrix();
  const auto [near_mm, far_mm] = depth_range_mm(shading, view);
  // Linear filtering is for those who ask for it by read_linear.
  const auto float4 = [&] { return gpu::Texture(context, w, h, gpu::Format::rgba32f, gpu::Filter::linear); };
  Frame frame{camera,
              view,
              camera.projection_matrix(near_mm, far_mm),
              float4(),
              float4(),
              float4(),
              float4(),
              gpu::Texture(context, w, h, gpu::Format::rg32f),
              gpu::Texture(context, w, h, gpu::Format::rgba32ui)};
  const gpu::Texture depth(context, w, h, gpu::Format::depth32f);
  std::vector<const gpu::Texture*> layers = {&frame.position,   &frame.face_normal, &frame.normal,
                                             &frame.irradiance, &frame.uv,          &frame.surface_id};
  if (surface.character_count() > 1) {
    frame.character = gpu::Texture(context, w, h, gpu::Format::r32f);
    layers.push_back(&frame.character);
  }
  const gpu::Framebuffer target(context, layers, &depth);
  const gpu::Program program(context, {methods::shader_file("frame/gbuffer.vert")},
                             {methods::shader_file("frame/gbuffer.frag")});
  target.clear();
  program.use();
  program.set("view", frame.view);
  program.set("projection", frame.projection);
  context.gl().Enable(GL_DEPTH_TEST);
  context.gl().DepthFunc(GL_LESS);
  surface.draw();
  context.gl().Disable(GL_DEPTH_TEST);
  context.check("rendering the frame");
  return frame;
}

FrameImages read_frame(const gpu::Context& context, const Frame& frame) {
  FrameImages images;
  images.position = gpu::read_texture(context, frame.position, 3);
  images.face_normal = gpu::read_texture(context, frame.face_normal, 3);
  images.normal = gpu::read_texture(context, frame.normal, 3);
  const Image irradiance = gpu::read_texture(context, frame.irradiance, 4);
  images.irradiance = Image(irradiance.width(), irradiance.height(), 3);
  images.mask = Image(irradiance.width(), irradiance.height(), 1);
  for (int y = 0; y < irradiance.height(); ++y) {
    for (int x = 0; x < irradiance.width(); ++x) {
      images.irradiance.set_rgb(x, y, irradiance.rgb(x, y));
      images.mask.at(x, y, 0) = irradiance.at(x, y, 3);
    }
  }
  const std::vector<std::uint32_t> ids = gpu::Framebuffer(context, {&frame.surface_id}).read_uint(0);
  images.surface.reserve(ids.size() / 4);
  for (std::size_t i = 0; i + 3 < ids.size(); i += 4) {
    PixelSurface surface;
    surface.triangle = static_cast<int>(ids[i]) - 1;
    // Interpolation may leave the triangle by a rounding error; the surface point may not.
    const double b1 = std::clamp(static_cast<double>(std::bit_cast<float>(ids[i + 1])), 0.0, 1.0);
    const double b2 = std::clamp(static_cast<double>(std::bit_cast<float>(ids[i + 2])), 0.0, 1.0 - b1);
    surface.barycentric = {1.0 - b1 - b2, b1, b2};
    images.surface.push_back(surface);
  }
  return images;
}

double median_skin_depth_mm(const FrameImages& images) {
  std::vector<float> depths;
  for (int y = 0; y < images.mask.height(); ++y) {
    for (int x = 0; x < images.mask.width(); ++x) {
      if (images.mask.at(x, y, 0) > 0.0F) depths.push_back(-images.position.at(x, y, 2));
    }
  }
  if (depths.empty()) return 0.0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

}  // namespace truescatter
