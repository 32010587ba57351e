#include "cli/cli_fixture.h"
#include "core/image_io.h"
#include "support/image_difference.h"

namespace truescatter::test {
namespace {

const std::string kSmall = kBallScene + R"(width_px = 48
height_px = 48
[[profile]]
name = "spike-and-base"
[truth]
geodesic = "off"
[timing]
warm_up = 0
repeats = 1
[[method]]
name = "pscbf"
[[method]]
name = "texture-space"
)";

class CliGl : public Cli {
 protected:
  ProgramResult run_by(const std::string& gl) const {
    folder_.write("e.toml", kSmall);
    return truescatter({"run", "e.toml", "--out", gl, "--gl", gl});
  }
  Image exitance(const std::string& gl, const std::string& method) const {
    return read_rgb(folder_.path() / gl / "maps" / ("front.spike-and-base." + method + ".exr"));
  }
};

// Mesa has one software rasteriser behind both, so the same shaders may differ by rounding alone: 2e-5 of the
// largest light, 1, is what the methods' manuals give it.
TEST_F(CliGl, EglGivesWhatOsMesaGives) {
  const ProgramResult egl = run_by("egl");
  if (egl.exit_code == 3 && contains(egl.err, "truescatter: EGL: "))
    GTEST_SKIP() << "EGL is not to be had here: " << egl.err;
  ASSERT_EQ(egl.exit_code, 0) << egl.err;
  const ProgramResult osmesa = run_by("osmesa");
  ASSERT_EQ(osmesa.exit_code, 0) << osmesa.err;
  const nlohmann::json by_egl = json("egl/results.json");
  const nlohmann::json by_osmesa = json("osmesa/results.json");
  EXPECT_EQ(by_egl["provenance"]["gl_context"], "egl");
  EXPECT_EQ(by_osmesa["provenance"]["gl_context"], "osmesa");
  EXPECT_EQ(by_osmesa["provenance"]["gl_software"], true);
  if (by_egl["provenance"]["gl_software"] == false)
    GTEST_SKIP() << "EGL has a GPU here, which rasterises by rules of its own: "
                 << by_egl["provenance"]["gl_renderer"];
  for (const char* method : {"pscbf", "texture-space"}) {
    const Image a = exitance("egl", method);
    const Image b = exitance("osmesa", method);
    EXPECT_LE(largest_difference(a, b), 2e-5) << method;
  }
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(by_egl["runs"][i]["cost"]["bytes_per_pixel"], by_osmesa["runs"][i]["cost"]["bytes_per_pixel"]);
}

// Without a driver (glvnd reads its drivers' names from the files that this variable names): an error that
// says so, and nothing is written.
TEST_F(CliGl, WithoutADriverEglFailsCleanly) {
  const EnvironmentVariable none("__EGL_VENDOR_LIBRARY_FILENAMES", (folder_.path() / "none.json").string());
  const ProgramResult result = run_by("egl");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_TRUE(contains(result.err, "truescatter: EGL: no OpenGL 4.5 core context without a window: "))
      << result.err;
  EXPECT_FALSE(exists("egl"));
}

TEST_F(CliGl, AnUnknownContextIsRefused) {
  const ProgramResult result = run_by("vulkan");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "vulkan")) << result.err;
  EXPECT_FALSE(exists("vulkan"));
}

}  // namespace
}  // namespace truescatter::test
