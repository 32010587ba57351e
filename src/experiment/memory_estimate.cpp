#include "experiment/memory_estimate.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "core/error.h"
#include "core/image_io.h"
#include "core/parallel.h"
#include "experiment/profile_truth.h"
#include "experiment/view_truth.h"
#include "gpu/texture.h"
#include "metrics/flip.h"
#include "truth/fast.h"
#include "truth/gauss_grid.h"
#include "truth/intrinsic_mesh.h"

namespace truescatter {
namespace {

constexpr std::uint64_t kGiB = std::uint64_t{1} << 30U;
constexpr std::uint64_t kMiB = std::uint64_t{1} << 20U;

// By measurement (resident memory of runs of small scenes, and of one more of the thing in question; glibc's
// malloc).
constexpr std::uint64_t kProgram = 256 * kMiB;  // 190 with Mesa's LLVM loaded, and what shaders take
constexpr double kEmbreePerTriangle = 200.0;    // its copy of the mesh, its tree, and while it is built
constexpr double kBinsPerTriangle = 200.0;      // what llvmpipe keeps of triangles that it has drawn
constexpr double kHashNode = 56.0;              // a node of an unordered_map of two words, with its bucket

constexpr double kFloat = sizeof(float);
constexpr double kCorner = sizeof(std::array<Vec3d, 3>);  // a vector at each corner of a triangle

// A kind of layer that engines convolve over a surface, as ViewTruth keeps them apart.
struct Layer {
  LayerKind kind;
  double std_dev_mm;
  double r_max_mm;

  bool operator<(const Layer& other) const {
    return std::tie(kind, std_dev_mm, r_max_mm) < std::tie(other.kind, other.std_dev_mm, other.r_max_mm);
  }
};

void add_layers(const ViewTruth::Request& request, double tolerance, std::set<Layer>& layers) {
  for (const GaussianLevel& level : gaussian_levels(*request.profile)) {
    const TruthLayer layer = truth_layer(level.variance_mm2, request.target, tolerance);
    layers.insert({kind_of(request.target), layer.std_dev_mm, layer.r_max_mm});
    if (request.target.visible_only) layers.insert({LayerKind::unsure, layer.std_dev_mm, layer.r_max_mm});
  }
}

// What a run computes, as far as it decides about memory.
struct Work {
  std::set<Layer> layers;
  double truths = 0.0;  // of the profile that has the most
  double methods = 0.0;
  double pictures = 0.0;  // truths and runs of all profiles
  bool geodesic = false;
  bool visible = false;
};

Work work_of(const ExperimentSpec& spec, const Plan& plan, bool has_uvs) {
  Work work;
  std::map<const Profile*, double> truths;
  for (const PlannedTruth& truth : planned_truths(plan, has_uvs)) {
    if (!truth.not_computed.empty()) continue;
    work.truths = std::max(work.truths, ++truths[truth.profile]);
    work.geodesic = work.geodesic || truth.target.follows_surface();
    work.visible = work.visible || truth.target.visible_only;
    if (!truth.target.transmittance)
      add_layers({truth.profile, truth.target}, spec.truth.tolerance, work.layers);
  }
  for (const auto& [name, model] : plan.models)
    add_layers(request_of(model), spec.truth.tolerance, work.layers);
  work.geodesic = work.geodesic || spec.truth.light_paths > 0;
  work.methods = static_cast<double>(plan.methods.size());
  work.pictures = static_cast<double>(plan.profiles.size()) * (1.0 + work.methods);
  return work;
}

// One stage's parts.
class Stage {
 public:
  explicit Stage(std::string name) { estimate_.stage = std::move(name); }

  Stage& add(const std::string& name, MemoryOf of, double bytes) {
    if (bytes > 0.0) estimate_.parts.push_back({name, of, static_cast<std::uint64_t>(std::ceil(bytes))});
    return *this;
  }
  MemoryEstimate sorted() const {
    MemoryEstimate result = estimate_;
    std::stable_sort(result.parts.begin(), result.parts.end(),
                     [](const MemoryPart& a, const MemoryPart& b) { return a.bytes > b.bytes; });
    return result;
  }

 private:
  MemoryEstimate estimate_;
};

class Model {
 public:
  Model(const ExperimentSpec& spec, const Plan& plan, const ViewSpec& view, const SceneSize& scene, int jobs)
      : spec_(spec),
        plan_(plan),
        view_(view),
        pixels_(static_cast<double>(view.width_px) * view.height_px),
        vertices_(static_cast<double>(scene.vertices)),
        triangles_(static_cast<double>(scene.triangles)),
        shading_(static_cast<double>(scene.shading_triangles)),
        has_uvs_(scene.has_uvs),
        jobs_(jobs),
        work_(work_of(spec, plan, scene.has_uvs)) {}

  MemoryEstimate peak() const {
    std::vector<MemoryEstimate> stages = {lighting(), truths(), methods(), pictures(), report()};
    if (spec_.metrics.leak) stages.push_back(leaks());
    if (spec_.stability && spec_.stability->of(view_)) stages.push_back(stability());
    return *std::max_element(stages.begin(), stages.end(),
                             [](const auto& a, const auto& b) { return a.bytes() < b.bytes(); });
  }

 private:
  Stage stage(const std::string& name) const {
    Stage stage(name);
    stage.add("the program", MemoryOf::program, static_cast<double>(kProgram));
    stage.add("the scene's textures", MemoryOf::texels, texture_bytes());
    return stage;
  }

  // What Images of the scene's textures take; a file that is none is told by who reads it.
  double texture_bytes() const {
    double bytes = 0.0;
    for (const auto* path : {&spec_.scene.albedo, &spec_.scene.normal_map, &spec_.scene.skin_mask,
                             &spec_.scene.transmitter_mask}) {
      bytes += image_bytes(*path);
    }
    if (spec_.composite) bytes += image_bytes(spec_.composite->regions);
    for (const LightSpec& light : spec_.lights) bytes += image_bytes(light.map);
    return bytes;
  }

  double image_bytes(const std::string& path) const {
    if (path.empty() || path.starts_with(kBuiltinPrefix)) return 0.0;
    return kFloat * image_values(expanded_path(spec_, path, {}));
  }

  double mesh_bytes() const {
    const double uvs = has_uvs_ ? sizeof(std::array<Vec2d, 3>) : 0.0;
    return vertices_ * sizeof(Vec3d) + triangles_ * (sizeof(std::array<int, 3>) + kCorner + uvs);
  }
  double shading_bytes() const { return vertices_ * sizeof(Vec3d) + shading_ * sizeof(ShadingTriangle); }

  // Fields of lights beside the mesh's own irradiance; a single light's is that (light_fields.h).
  double light_fields() const {
    const auto fields = std::count_if(spec_.lights.begin(), spec_.lights.end(), [](const LightSpec& light) {
      return light.type != "environment" && light.shadows;
    });
    return fields == 1 && spec_.lights.size() == 1 ? 0.0 : static_cast<double>(fields);
  }

  double occluded_environments() const {
    return static_cast<double>(
        std::count_if(spec_.lights.begin(), spec_.lights.end(),
                      [](const LightSpec& light) { return light.type == "environment" && light.occlusion; }));
  }

  // Loading, Embree and refinement; refine.cpp keeps a sample of the light at each vertex and, where an edge
  // is longer than the floor, at its middle, in a table by edge; components are found by another table.
  MemoryEstimate lighting() const {
    const double sample = sizeof(std::vector<int>) + 16.0 + sizeof(Vec3d) * 3.0 + sizeof(std::size_t);
    const double edges = 1.5 * shading_ * (kHashNode + sample);
    return stage("lighting the mesh")
        .add("mesh", MemoryOf::triangles, mesh_bytes())
        .add("shading mesh", MemoryOf::triangles, shading_bytes())
        .add("shadow rays (Embree)", MemoryOf::triangles, kEmbreePerTriangle * triangles_)
        .add("light at edges and vertices", MemoryOf::triangles, edges + vertices_ * sample)
        .sorted();
  }

  // What stays while views are drawn: the mesh, lit; corner by corner on the GPU, 17 floats each and 3 for
  // each light; and as the truths' surfaces.
  Stage& add_scene(Stage& stage) const {
    const double gpu = 3.0 * kFloat * (17.0 + 3.0 * light_fields());
    if (spec_.composite && spec_.composite->specular) {
      stage.add("what occlusion leaves of environments", MemoryOf::triangles,
                shading_ * kCorner * occluded_environments());
    }
    stage.add("mesh", MemoryOf::triangles, mesh_bytes())
        .add("shading mesh", MemoryOf::triangles, shading_bytes() + shading_ * kCorner * light_fields())
        .add("surface on the GPU", MemoryOf::triangles, shading_ * (gpu + kBinsPerTriangle))
        .add("truths' surface", MemoryOf::triangles, shading_ * sizeof(SurfaceTriangle));
    if (work_.geodesic) {
      const double face = sizeof(std::array<int, 3>) + 3.0 * sizeof(IntrinsicMesh::Crossing) +
                          2.0 * sizeof(std::array<Vec2d, 3>) + 3.0 * sizeof(std::array<double, 3>) +
                          sizeof(std::size_t);
      stage.add("geodesics' surface", MemoryOf::triangles,
                triangles_ * face + vertices_ * sizeof(IntrinsicMesh::Vertex) +
                    shading_ * (sizeof(FlatPiece) + sizeof(GeodesicPiece)));
    }
    return stage;
  }

  // A frame in host memory, whether the rasteriser's (OSMesa's textures are there) or a GPU driver's.
  double frame_bytes() const {
    using gpu::Format;
    double texel = gpu::bytes_per_texel(Format::rg32f) + gpu::bytes_per_texel(Format::rgba32ui) +
                   gpu::bytes_per_texel(Format::depth32f);
    for (int i = 0; i < 4; ++i) texel += gpu::bytes_per_texel(Format::rgba32f);
    if (spec_.scene.characters.size() > 1) texel += gpu::bytes_per_texel(Format::r32f);
    return pixels_ * texel;
  }
  double host_frame_bytes() const { return pixels_ * (13.0 * kFloat + sizeof(PixelSurface)); }
  static double point_bytes() {
    return sizeof(ViewPoints::Pixel) + sizeof(int) + sizeof(SurfacePoint) + sizeof(GeodesicTarget) +
           sizeof(Vec3d);
  }
  double layer_bytes() const { return static_cast<double>(work_.layers.size()) * sizeof(Vec4d); }

  // Frame, points behind its pixels, contours (two classes, a flag, a distance), what is measured apart.
  Stage& add_view(Stage& stage) const {
    double kept = 3.0 * sizeof(char) + sizeof(double);
    if (spec_.metrics.seam) kept += sizeof(double) + kFloat;
    if (!spec_.scene.albedo.empty()) kept += 3.0 * kFloat;
    // Albedo and specular light are kept; while it is made, each light's picture and textures of four
    // channels.
    if (spec_.composite) kept += (6.0 + 4.0 * 5.0 + 3.0 * static_cast<double>(spec_.lights.size())) * kFloat;
    return stage.add("frame", MemoryOf::pixels, frame_bytes() + host_frame_bytes())
        .add("points and contours", MemoryOf::pixels, pixels_ * (point_bytes() + kept))
        .add(fmt::format("truths of {} Gaussians", work_.layers.size()), MemoryOf::pixels,
             pixels_ * layer_bytes());
  }

  // FastEngine: a box, its node of the tree (half a leaf's and half an inner one's for at least four
  // triangles), bounds, and a rule of each of three plans.
  static double engine_bytes() {
    return 1.5 * sizeof(Eigen::AlignedBox3d) + 4.0 * sizeof(int) + sizeof(TriangleBounds) +
           3.0 * sizeof(Split) + 1.0;
  }
  // A quadrature node with its key of the lattice's order.
  static double node_bytes() { return sizeof(GaussSource) + 2.0 * sizeof(std::uint64_t); }

  // The lattice's blocks around the surface in view, at the distance of the target, and 1.5 times that for
  // its slant; a layer of them is as thick as the lattice's span. It is taken only where it costs less than
  // summing directly does, which bounds its cells for each point: by the closed form's cost at the six
  // triangles around a vertex, and at those that lie within reach if all of the scene's lie in view.
  double lattice_bytes(double std_dev_mm) const {
    constexpr double kVisitCost = 900.0;    // fast.cpp has these, and the share of the tolerance for
    constexpr double kGroupCost = 20000.0;  // lattice and tail
    const double share = 0.1 * spec_.truth.tolerance;
    const GaussLattice lattice(std_dev_mm, share);
    const double cell_mm = kGaussBlock * lattice.step_mm;
    const double px_mm = (view_.eye_mm - view_.target_mm).norm() / camera_of(view_).focal_px();
    const double px_mm2 = px_mm * px_mm;
    const double reach2_mm2 = -2.0 * std::log(share) * std_dev_mm * std_dev_mm;
    const double near = 6.0 + shading_ * std::min(1.0, kPi * reach2_mm2 / (pixels_ * px_mm2));
    const double worth = (kClosedCost * near - kVisitCost) / kGroupCost;
    const double cells = pixels_ * std::min({1.0, 1.5 * px_mm2 / (cell_mm * cell_mm), worth});
    const double scalar = spec_.truth.tolerance >= 1e-5 ? sizeof(float) : sizeof(double);
    constexpr double kBlockPoints = kGaussBlock * kGaussBlock * kGaussBlock;
    return cells * lattice.span * (kBlockPoints * 4.0 * scalar + kHashNode);
  }

  MemoryEstimate truths() const {
    std::set<LayerKind> kinds;
    double lattice = 0.0;
    for (const Layer& layer : work_.layers) {
      kinds.insert(layer.kind);
      if (layer.kind != LayerKind::geodesic) lattice = std::max(lattice, lattice_bytes(layer.std_dev_mm));
    }
    // One of them at a time: ids twice, positions (and as they grow), sums, their order in the lattice, and
    // as many nodes; or a layer on its way to the cache, twice.
    const double one =
        2.0 * sizeof(int) + 2.0 * sizeof(Vec3d) + sizeof(Vec4d) + 2.0 * sizeof(std::uint64_t) + node_bytes();
    Stage result = stage("computing truths");
    add_view(add_scene(result))
        .add("truths' search", MemoryOf::triangles,
             shading_ * (static_cast<double>(kinds.size()) * engine_bytes() + node_bytes()))
        .add("one Gaussian's convolution", MemoryOf::pixels, pixels_ * one + lattice);
    if (work_.visible) {
      // Its pieces are half a pixel, joined where all of a triangle is seen; by measurement.
      result
          .add("visible surface", MemoryOf::pixels,
               pixels_ * 0.5 * (sizeof(SurfaceTriangle) + engine_bytes()))
          .add("visible surface", MemoryOf::triangles,
               kEmbreePerTriangle * triangles_ + 2.0 * shading_ * sizeof(SurfaceTriangle));
    }
    return result.sorted();
  }

  // Each truth's picture, mass, mask; two more of a model's profile itself; the references of both FLIPs,
  // the second at as many exposures as the truth's tolerance lets it have.
  double truth_picture_bytes() const {
    const double models = plan_.models.empty() ? 0.0 : 2.0;
    return pixels_ * (work_.truths + models) * 5.0 * kFloat;
  }
  double flip_bytes() const {
    const int exposures = 1 + static_cast<int>(std::ceil(std::log2(1.0 / spec_.truth.tolerance)));
    const int references = spec_.composite ? 2 : 1;  // of the exitance, and of the picture as seen
    return references * FlipReference::kept_bytes(pixels_) + HdrFlipReference::kept_bytes(pixels_, exposures);
  }

  // What drawing holds: the largest of the methods, and what counts its reads: two targets, a depth, and
  // both read back.
  double drawing_bytes(MemoryOf of) const {
    constexpr double kCounting = 16.0 + 16.0 + 4.0 + 16.0 + 2.0 * kFloat;
    double largest = 0.0;
    for (const PlannedMethod& planned : plan_.methods) {
      const MethodMemory& memory = planned.method->memory;
      if (of == MemoryOf::pixels) largest = std::max(largest, pixels_ * (memory.bytes_per_pixel + kCounting));
      if (of != MemoryOf::texels || memory.bytes_per_texel == 0.0) continue;
      const double size = planned.settings.number("texture_size");
      largest = std::max(largest, size * size * (memory.bytes_per_texel + kCounting));
    }
    return largest;
  }

  MemoryEstimate methods() const {
    Stage result = stage("drawing and measuring methods");
    // A picture beside its error's, as they are measured or written: FLIP's filters in double precision (ten
    // planes) and what they give; or all layers of an EXR, interleaved and encoded.
    constexpr double kMeasuring = 6.0 * kFloat + 10.0 * sizeof(double) + 7.0 * kFloat;
    // A composite: what scatters, and four textures of four channels with as much on the host of one of them;
    // then the picture and what of it is visible, among an EXR's layers too.
    constexpr double kComposing = (3.0 + 4.0 * 4.0 + 4.0) * kFloat;
    constexpr double kComposed = 2.0 * 4.0 * kFloat;
    const double rungs = static_cast<double>(std::accumulate(
        plan_.ladders.begin(), plan_.ladders.end(), std::size_t{0},
        [](std::size_t most, const LadderSpec& ladder) { return std::max(most, ladder.rungs.size()); }));
    return add_view(add_scene(result))
        .add("truths' pictures", MemoryOf::pixels, truth_picture_bytes())
        .add("FLIP's references", MemoryOf::pixels, flip_bytes())
        .add(
            "methods' targets or measuring", MemoryOf::pixels,
            std::max(drawing_bytes(MemoryOf::pixels),
                     pixels_ * (spec_.composite ? std::max(kMeasuring + kComposed, kComposing) : kMeasuring)))
        // Pictures of a ladder's runs, their steps, and these in one file.
        .add("ladder", MemoryOf::pixels, pixels_ * rungs * 4.0 * 3.0 * kFloat)
        .add("methods' maps in texture space", MemoryOf::texels, drawing_bytes(MemoryOf::texels))
        .sorted();
  }

  // One surface lit alone: the shading mesh again, on the host and on the GPU, a frame, and a method.
  MemoryEstimate leaks() const {
    Stage result = stage("measuring leaks");
    const double corners = 2.0 * 3.0 * 17.0 * kFloat + 2.0 * kCorner * light_fields();
    return add_view(add_scene(result))
        .add("surfaces lit alone", MemoryOf::triangles, shading_ * (sizeof(ShadingTriangle) + corners))
        .add("surfaces lit alone", MemoryOf::pixels, frame_bytes() + drawing_bytes(MemoryOf::pixels))
        .add("methods' maps in texture space", MemoryOf::texels, drawing_bytes(MemoryOf::texels))
        .sorted();
  }

  // A frame of another view, its images twice, and the truths and errors at the points that are followed.
  MemoryEstimate stability() const {
    const double asked = spec_.stability->points;
    const double points = asked > 0.0 ? std::min(asked, pixels_) : pixels_;
    const double runs = work_.methods * static_cast<double>(plan_.profiles.size());
    constexpr double kSpreads = 4.0 * 3.0 * sizeof(double);  // of each run: four quantities
    Stage result = stage("following points through views");
    return add_scene(result)
        .add("frame", MemoryOf::pixels, frame_bytes() + 2.0 * host_frame_bytes())
        .add("followed points", MemoryOf::pixels,
             points * (2.0 * point_bytes() + layer_bytes() + runs * kSpreads))
        .add("truths' search", MemoryOf::triangles, shading_ * (engine_bytes() + node_bytes()))
        .add("truths' pictures", MemoryOf::pixels, pixels_ * 5.0 * kFloat)
        .add("methods' targets", MemoryOf::pixels, drawing_bytes(MemoryOf::pixels))
        .add("methods' maps in texture space", MemoryOf::texels, drawing_bytes(MemoryOf::texels))
        .sorted();
  }

  // The scene is gone.
  MemoryEstimate pictures() const {
    const double at_once = std::min<double>(jobs_within(pixels_ * kPictureJobBytes, jobs_), work_.pictures);
    Stage result = stage("making pictures");
    return result.add("view's images", MemoryOf::pixels, pixels_ * 8.0 * kFloat)
        .add("pictures at once", MemoryOf::pixels, at_once * pixels_ * kPictureJobBytes)
        .sorted();
  }

  // Three 16-bit values a pixel of every truth and run, deflated at worst not at all, in base 64.
  MemoryEstimate report() const {
    double all = 0.0;
    for (const ViewSpec& view : spec_.views) all += static_cast<double>(view.width_px) * view.height_px;
    const double at_once = std::min<double>(jobs_within(pixels_ * kPictureJobBytes, jobs_), work_.pictures);
    Stage result = stage("writing the report");
    return result.add("values of all pictures", MemoryOf::pixels, all * work_.pictures * 6.0 * 4.0 / 3.0)
        .add("pictures at once", MemoryOf::pixels, at_once * pixels_ * kPictureJobBytes)
        .sorted();
  }

  const ExperimentSpec& spec_;
  const Plan& plan_;
  const ViewSpec& view_;
  double pixels_;
  double vertices_;
  double triangles_;
  double shading_;
  bool has_uvs_;
  int jobs_;
  Work work_;
};

std::string largest_parts(const MemoryEstimate& estimate) {
  std::vector<std::string> texts;
  for (const MemoryPart& part : estimate.parts) {
    if (texts.size() < 3) texts.push_back(fmt::format("{} {}", part.name, memory_text(part.bytes)));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

// What the estimate grows with most comes first.
std::string what_lowers(const MemoryEstimate& estimate, const ViewSpec& view, const SceneSize& scene) {
  std::vector<std::pair<std::uint64_t, std::string>> ways = {
      {estimate.bytes_of(MemoryOf::pixels),
       fmt::format("fewer pixels ({} x {}) or Gaussians", view.width_px, view.height_px)},
      {estimate.bytes_of(MemoryOf::triangles), fmt::format("fewer triangles ({})", scene.shading_triangles)},
      {estimate.bytes_of(MemoryOf::texels), "smaller textures or maps in texture space"}};
  std::erase_if(ways, [&](const auto& way) { return way.first < estimate.bytes() / 10; });
  std::sort(ways.begin(), ways.end(), std::greater<>());
  std::vector<std::string> texts;
  texts.reserve(ways.size() + 1);
  for (const auto& [bytes, text] : ways) texts.push_back(text);
  texts.emplace_back("other methods and truths");
  return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace

std::uint64_t MemoryEstimate::bytes() const {
  std::uint64_t sum = 0;
  for (const MemoryPart& part : parts) sum += part.bytes;
  return sum;
}

std::uint64_t MemoryEstimate::bytes_of(MemoryOf of) const {
  std::uint64_t sum = 0;
  for (const MemoryPart& part : parts) {
    if (part.of == of) sum += part.bytes;
  }
  return sum;
}

SceneSize size_of(const SceneOutline& outline) {
  return {outline.vertices, outline.triangles, outline.triangles, outline.has_uvs};
}

SceneSize size_of(const Mesh& mesh) {
  return {mesh.positions_mm.size(), mesh.triangle_count(), mesh.triangle_count(), mesh.has_uvs()};
}

SceneSize size_of(const PreparedScene& scene) {
  SceneSize size = size_of(scene.mesh);
  size.shading_triangles = scene.shading.triangles.size();
  return size;
}

MemoryEstimate estimate_memory(const ExperimentSpec& spec, const Plan& plan, const ViewSpec& view,
                               const SceneSize& scene, int jobs) {
  return Model(spec, plan, view, scene, jobs).peak();
}

std::uint64_t default_memory_limit() {
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long page_bytes = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return 16 * kGiB;
  return std::min(16 * kGiB, static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes));
}

void refuse_beyond_memory(const ExperimentSpec& spec, const Plan& plan, const SceneSize& scene,
                          std::uint64_t limit_bytes) {
  for (const ViewSpec& view : spec.views) {
    const MemoryEstimate estimate = estimate_memory(spec, plan, view, scene, job_count());
    if (estimate.bytes() <= limit_bytes) continue;
    throw_input_error({spec.file.string()},
                      "scene {}, view '{}': {} needs about {} of memory ({}), and --memory-limit is {}; {} "
                      "would lower it",
                      spec.scene.mesh, view.name, estimate.stage, memory_text(estimate.bytes()),
                      largest_parts(estimate), memory_text(limit_bytes), what_lowers(estimate, view, scene));
  }
}

std::string describe_memory(const ExperimentSpec& spec, const Plan& plan, const SceneSize& scene) {
  std::string text;
  for (const ViewSpec& view : spec.views) {
    const MemoryEstimate estimate = estimate_memory(spec, plan, view, scene, job_count());
    text += fmt::format("memory view {}: about {} at most, {} ({})\n", view.name,
                        memory_text(estimate.bytes()), estimate.stage, largest_parts(estimate));
  }
  return text;
}

std::uint64_t peak_memory() {
  rusage usage{};
  // In KiB on Linux.
  return getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::uint64_t>(usage.ru_maxrss) * 1024U : 0;
}

std::string memory_text(std::uint64_t bytes) {
  const auto mib = static_cast<double>(bytes) / static_cast<double>(kMiB);
  return mib < 1000.0 ? fmt::format("{:.0f} MiB", mib) : fmt::format("{:.1f} GiB", mib / 1024.0);
}

}  // namespace truescatter
