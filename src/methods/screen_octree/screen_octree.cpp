#include <cmath>
#include <memory>

#include "core/parallel.h"
#include "methods/method.h"
#include "methods/screen_octree/sample_octree.h"

namespace truescatter {
namespace {

constexpr double kReachStdDevs = 5.5;

// The manual stands at the head of screen_octree.frag.
struct State {
  PassProgram weigh;
  PassProgram back_position;
  PassProgram back_weighted;
  Target front_weighted;
  Target back_position_target;
  Target back_weighted_target;
  gpu::Texture output;
  std::vector<GaussianLevel> levels;
  Vec3d delta_weight;
  double solid_angle;
  bool normalised;
};

void draw_buffers(Passes& passes, const State& state, const Frame& frame, const SurfaceBuffers& surface) {
  passes.draw(state.weigh, state.front_weighted, [&](const gpu::Program& program) {
    program.set("irradiance", frame.irradiance, 0);
    program.set("position", frame.position, 1);
    program.set("face_normal", frame.face_normal, 2);
  });
  const auto draw_back = [&](const PassProgram& program, const Target& to) {
    passes.draw_geometry(
        program, to,
        [&](const gpu::Program& used) {
          used.set("view", frame.view);
          used.set("projection", frame.projection);
          used.set("front", frame.position, 0);
        },
        [&] { surface.draw(); });
  };
  draw_back(state.back_position, state.back_position_target);
  draw_back(state.back_weighted, state.back_weighted_target);
}

void add_samples(std::vector<SurfaceSample>& samples, const Image& position, const Image& weighted,
                 double focal_px) {
  for (int y = 0; y < position.height(); ++y) {
    for (int x = 0; x < position.width(); ++x) {
      const double weight = weighted.at(x, y, 3);
      if (weight > 0.0)
        samples.push_back({position.rgb(x, y), weighted.rgb(x, y) / weight, weight / (focal_px * focal_px)});
    }
  }
}

// The exitance at a point that receives `irradiance`.
Vec3d exitance(const State& state, const SampleOctree& tree, const Vec3d& at, const Vec3d& irradiance) {
  std::vector<Vec3d> light(state.levels.size(), Vec3d::Zero());
  std::vector<double> mass(state.levels.size(), 0.0);
  // The levels ascend: the last is the widest.
  const double reach_mm = state.levels.empty() ? 0.0 : kReachStdDevs * state.levels.back().std_dev_mm();
  tree.gather(at, reach_mm, state.solid_angle, [&](const SurfaceSample& sample) {
    const double distance2 = (sample.position_mm - at).squaredNorm();
    for (std::size_t i = state.levels.size(); i-- > 0;) {
      const double variance = state.levels[i].variance_mm2;
      if (distance2 > kReachStdDevs * kReachStdDevs * variance) return;
      const double weight = sample.area_mm2 * std::exp(-0.5 * distance2 / variance);
      light[i] += weight * sample.irradiance;
      mass[i] += weight;
    }
  });
  Vec3d sum = state.delta_weight.cwiseProduct(irradiance);
  for (std::size_t i = 0; i < state.levels.size(); ++i) {
    const double divisor = state.normalised ? mass[i] : 2.0 * kPi * state.levels[i].variance_mm2;
    // The point's own sample is always there, unless its area is 0.
    if (divisor > 0.0) sum += state.levels[i].weight.cwiseProduct(light[i]) / divisor;
  }
  return sum;
}

Image gathered(const State& state, const gpu::Context& context, const Frame& frame) {
  const Image position = gpu::read_texture(context, frame.position, 3);
  const Image irradiance = gpu::read_texture(context, frame.irradiance, 4);
  std::vector<SurfaceSample> samples;
  const double focal_px = frame.camera.focal_px();
  add_samples(samples, position, gpu::read_texture(context, state.front_weighted.texture, 4), focal_px);
  add_samples(samples, gpu::read_texture(context, state.back_position_target.texture, 3),
              gpu::read_texture(context, state.back_weighted_target.texture, 4), focal_px);
  const SampleOctree tree(std::move(samples));
  Image result = irradiance;
  parallel_for(static_cast<std::size_t>(result.height()), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < result.width(); ++x) {
      if (irradiance.at(x, y, 3) > 0.0F)
        result.set_rgb(x, y, exitance(state, tree, position.rgb(x, y), irradiance.rgb(x, y)));
    }
  });
  return result;
}

PreparedMethod prepare(const MethodInputs& inputs) {
  const gpu::Context& context = inputs.context;
  const Frame& frame = inputs.frame;
  const int width = frame.camera.width_px;
  const int height = frame.camera.height_px;
  const auto back_program = [&](const std::vector<std::string>& defines) {
    return PassProgram::of_pieces(context, "frame/gbuffer.vert",
                                  {"filter_geometry.glsl", "screen_octree/screen_octree.frag"}, defines);
  };
  const auto back_target = [&] { return Target::with_depth(context, width, height, gpu::Format::rgba32f); };
  const auto state = std::make_shared<State>(State{
      PassProgram::of_pieces(context, {}, {"filter_geometry.glsl", "weighted.frag"}),
      back_program({"BACK_POSITION"}), back_program({}), Target(context, width, height, gpu::Format::rgba32f),
      back_target(), back_target(), gpu::Texture(context, width, height, gpu::Format::rgba32f),
      gaussian_levels(inputs.profile), inputs.profile.delta_weight, inputs.settings.number("solid_angle"),
      inputs.settings.word("sum") == "normalised"});
  const SurfaceBuffers& surface = inputs.surface;
  const auto render = [state, &frame, &surface](Passes& passes) {
    draw_buffers(passes, *state, frame, surface);
    passes.show(state->front_weighted.texture, "front-light", "RGBw",
                "irradiance times the area weight w(p), and w(p), mm^2");
    passes.show(state->back_position_target.texture, "back-position", "XYZ",
                "view-space position on the farthest surface, mm");
    passes.show(state->back_weighted_target.texture, "back-light", "RGBw",
                "its irradiance times w(p), and w(p), mm^2");
    state->output.upload(gathered(*state, passes.context(), frame));
  };
  return {render, &state->output};
}

}  // namespace

Method screen_octree_method() {
  Method method;
  method.name = "screen-octree";
  method.title = "Octree over front and back buffers";
  method.source = "van Lommel 2007; Jensen & Buhler 2002";
  method.limits = {.rounding = 1e-5};
  // Four targets and two depths; what is read of them; and for each of two samples a pixel its entry and, in
  // a leaf of eight and often fewer, a share of the octree.
  method.memory = {.bytes_per_pixel =
                       4.0 * 16.0 + 2.0 * 4.0 + 5.0 * 16.0 + 2.0 * 3.0 * sizeof(SurfaceSample)};
  method.settings = {
      {"solid_angle", "below which a voxel counts as one sample, steradians", 0.05, 0.0, 12.0},
      {"sum", "divided by its own weights, or not", 0.0, 0.0, 0.0, false, {"normalised", "raw"}}};
  method.own_target = [](const Profile&, const Settings& settings) {
    return OwnTarget{false, settings.word("sum") == "normalised", std::nullopt};
  };
  method.prepare = prepare;
  return method;
}

}  // namespace truescatter
