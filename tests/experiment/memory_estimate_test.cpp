#include "experiment/memory_estimate.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/error.h"
#include "core/image_io.h"
#include "experiment/view_points.h"
#include "gpu/texture.h"
#include "support/plane_experiment.h"
#include "support/temp_dir.h"
#include "truth/surface.h"

namespace truescatter::test {
namespace {

const std::string kMethods = R"(
[[profile]]
name = "one"
r_max_mm = 3.0
[[profile.gaussian]]
variance_mm2 = 1.0
weight = 1.0
[[method]]
name = "none"
[truth]
geodesic = "off"
)";

constexpr std::uint64_t kGiB = std::uint64_t{1} << 30U;

class MemoryEstimates : public testing::Test {
 protected:
  ExperimentSpec read(const std::string& more = "") const {
    return read_experiment(folder_.write("e.toml", kPlane + kMethods + more));
  }
  static MemoryEstimate of(ExperimentSpec spec, int width_px, int height_px, const SceneSize& scene) {
    spec.views.front().width_px = width_px;
    spec.views.front().height_px = height_px;
    return estimate_memory(spec, make_plan(spec), spec.views.front(), scene, 1);
  }

  TempDir folder_;
};

SceneSize of_triangles(std::uint64_t count) { return {count / 2, count, count, true}; }

// Each part is rounded up to a byte.
void expect_doubled(std::uint64_t one, std::uint64_t two, const MemoryEstimate& parts) {
  EXPECT_NEAR(static_cast<double>(two), 2.0 * static_cast<double>(one),
              2.0 * static_cast<double>(parts.parts.size()));
}

TEST_F(MemoryEstimates, IsTheSumOfItsPartsLargestFirst) {
  const MemoryEstimate estimate = of(read(), 640, 480, of_triangles(100000));
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < estimate.parts.size(); ++i) {
    sum += estimate.parts[i].bytes;
    if (i == 0) continue;
    EXPECT_LE(estimate.parts[i].bytes, estimate.parts[i - 1].bytes);
  }
  EXPECT_EQ(estimate.bytes(), sum);
  EXPECT_EQ(estimate.bytes_of(MemoryOf::pixels) + estimate.bytes_of(MemoryOf::triangles) +
                estimate.bytes_of(MemoryOf::texels) + estimate.bytes_of(MemoryOf::program),
            sum);
}

// A field of view is across the height: twice the width is twice as much of the same.
TEST_F(MemoryEstimates, DoublesWithThePixels) {
  const ExperimentSpec spec = read();
  const MemoryEstimate one = of(spec, 1000, 1000, of_triangles(1000));
  const MemoryEstimate two = of(spec, 2000, 1000, of_triangles(1000));
  ASSERT_EQ(one.stage, two.stage);
  expect_doubled(one.bytes_of(MemoryOf::pixels), two.bytes_of(MemoryOf::pixels), one);
  EXPECT_EQ(one.bytes_of(MemoryOf::triangles), two.bytes_of(MemoryOf::triangles));
  EXPECT_EQ(one.bytes_of(MemoryOf::program), two.bytes_of(MemoryOf::program));
}

TEST_F(MemoryEstimates, DoublesWithTheTriangles) {
  const ExperimentSpec spec = read();
  const MemoryEstimate one = of(spec, 100, 100, of_triangles(1000000));
  const MemoryEstimate two = of(spec, 100, 100, of_triangles(2000000));
  ASSERT_EQ(one.stage, two.stage);
  expect_doubled(one.bytes_of(MemoryOf::triangles), two.bytes_of(MemoryOf::triangles), one);
  EXPECT_EQ(one.bytes_of(MemoryOf::pixels), two.bytes_of(MemoryOf::pixels));
}

// What every run holds at once of a pixel and of a triangle, by hand.
TEST_F(MemoryEstimates, HoldsNoLessThanWhatIsThereAtOnce) {
  using gpu::Format;
  const double frame = 4.0 * gpu::bytes_per_texel(Format::rgba32f) + gpu::bytes_per_texel(Format::rg32f) +
                       gpu::bytes_per_texel(Format::rgba32ui);
  const double images = 13.0 * sizeof(float) + sizeof(PixelSurface);
  const double points = sizeof(SurfacePoint) + sizeof(GeodesicTarget) + sizeof(Vec3d);
  const double layer = sizeof(Vec4d);
  const MemoryEstimate wide = of(read(), 4096, 4096, {});
  EXPECT_GE(static_cast<double>(wide.bytes_of(MemoryOf::pixels)),
            4096.0 * 4096.0 * (frame + images + points + layer));
  const double mesh = 0.5 * sizeof(Vec3d) + sizeof(std::array<int, 3>) + sizeof(std::array<Vec3d, 3>);
  const double corners = 3.0 * 17.0 * sizeof(float);
  const MemoryEstimate fine = of(read(), 64, 64, of_triangles(5000000));
  EXPECT_GE(static_cast<double>(fine.bytes_of(MemoryOf::triangles)),
            5e6 * (mesh + sizeof(ShadingTriangle) + corners + sizeof(SurfaceTriangle)));
}

TEST_F(MemoryEstimates, GrowsWithWhatARunDoes) {
  const auto bytes = [&](const std::string& more) {
    return of(read(more), 1024, 1024, of_triangles(500000)).bytes();
  };
  const std::uint64_t plain = bytes("");
  EXPECT_GT(bytes("[[profile]]\nname = \"skin-six-gaussian\"\n"), plain);
  EXPECT_GT(bytes("[[method]]\nname = \"pscbf\"\n"), plain);  // a truth of its own
  EXPECT_GT(bytes("[[method]]\nname = \"screen-octree\"\n"), plain);
  EXPECT_GT(bytes("[metrics]\nseam = true\n"), plain);
  const std::string leaks = "[[method]]\nname = \"cbf\"\n[metrics]\nleak = ";
  EXPECT_GE(bytes(leaks + "true\n"), bytes(leaks + "false\n"));
  const std::string maps = "[[method]]\nname = \"texture-space\"\n[method.settings]\ntexture_size = ";
  EXPECT_GT(bytes(maps + "4096\n"), bytes(maps + "2048\n"));
}

TEST_F(MemoryEstimates, CountsTheScenesTextures) {
  const Image map(256, 128, 3, 0.5F);
  write_exr(folder_.path() / "map.exr", {{"", &map}});
  ExperimentSpec spec = read();
  const MemoryEstimate without = of(spec, 64, 64, of_triangles(1000));
  spec.scene.albedo = "map.exr";
  const MemoryEstimate with = of(spec, 64, 64, of_triangles(1000));
  EXPECT_EQ(without.bytes_of(MemoryOf::texels), 0U);
  EXPECT_EQ(with.bytes_of(MemoryOf::texels), 256U * 128U * 3U * sizeof(float));
}

// 10^10 pixels and 2^31 triangles at once: more than 2^42 bytes, and the sum of two runs of one each.
TEST_F(MemoryEstimates, DoNotOverflow) {
  const std::uint64_t most = std::uint64_t{1} << 31U;
  const ExperimentSpec spec = read();
  const MemoryEstimate both = of(spec, 100000, 100000, of_triangles(most));
  EXPECT_GT(both.bytes(), std::uint64_t{1} << 42U);
  EXPECT_GE(both.bytes(), of(spec, 100000, 100000, {}).bytes());
  EXPECT_GE(both.bytes(), of(spec, 1, 1, of_triangles(most)).bytes());
}

TEST_F(MemoryEstimates, BeyondTheLimitAreRefusedByName) {
  ExperimentSpec spec = read();
  spec.views.front().width_px = spec.views.front().height_px = 100000;
  const Plan plan = make_plan(spec);
  const SceneSize scene = of_triangles(1000);
  const std::uint64_t bytes = estimate_memory(spec, plan, spec.views.front(), scene, 1).bytes();
  EXPECT_NO_THROW(refuse_beyond_memory(spec, plan, scene, std::uint64_t{1} << 62U));
  try {
    refuse_beyond_memory(spec, plan, scene, 16 * kGiB);
    FAIL() << bytes;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
    const std::string message = error.what();
    for (const char* piece : {"e.toml: scene builtin:plane, view 'front': ", "needs about ",
                              "--memory-limit is 16.0 GiB", "fewer pixels (100000 x 100000) or Gaussians"})
      EXPECT_NE(message.find(piece), std::string::npos) << piece << "\nin\n" << message;
  }
}

TEST_F(MemoryEstimates, AreListedForEachView) {
  const ExperimentSpec spec = read("[[view]]\nname = \"large\"\neye_mm = [0, 0, 100]\nwidth_px = 2048\n");
  const std::string text = describe_memory(spec, make_plan(spec), of_triangles(1000));
  EXPECT_NE(text.find("memory view front: about "), std::string::npos) << text;
  EXPECT_NE(text.find("memory view large: about "), std::string::npos) << text;
}

TEST(MemoryLimit, IsSixteenGibibytesAtMost) {
  EXPECT_LE(default_memory_limit(), 16 * kGiB);
  EXPECT_GT(default_memory_limit(), 0U);
}

// What is written to stays in the peak.
TEST(PeakMemory, GrowsWithWhatIsUsed) {
  const std::uint64_t before = peak_memory();
  ASSERT_GT(before, 0U);
  // More than the whole process has had: other pages than those that were freed.
  const std::vector<char> block(before + (64U << 20U), 1);
  EXPECT_GE(peak_memory(), block.size());
}

TEST(MemoryText, IsShort) {
  EXPECT_EQ(memory_text(340ULL << 20U), "340 MiB");
  EXPECT_EQ(memory_text(3ULL << 29U), "1.5 GiB");
}

}  // namespace
}  // namespace truescatter::test
