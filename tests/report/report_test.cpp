#include "report/report.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "core/error.h"
#include "core/file.h"
#include "core/image.h"
#include "core/image_io.h"

namespace truescatter {
namespace {

using nlohmann::json;

// Everything that could end a script block, an attribute or a text early.
constexpr const char* kHostileName = R"(a <b> & "c" 'd' </script><!-- {{scripts}} )";

json error_metrics(double scale) {
  json metrics = {{"pixels", 12},       {"bias", -0.1 * scale},    {"mae", 0.5 * scale},
                  {"rmse", scale},      {"rel_rmse", 2.0 * scale}, {"p50", 0.3 * scale},
                  {"p95", 2.0 * scale}, {"p99", 3.0 * scale},      {"max", 4.0 * scale}};
  return metrics;
}

json halo() {
  return {{"pixels", 4},
          {"peak", 0.1},
          {"width_mm", nullptr},
          {"width_mm_reason", "the error stays above 1 % up to 6 s"},
          {"energy", 0.02},
          {"contrast", nullptr},
          {"contrast_reason", "no pixel beyond 6 s"},
          {"profile", {{"bin_mm", 0.5}, {"relative_error", {0.1, nullptr, -0.02}}, {"pixels", {2, 0, 2}}}}};
}

json metrics(double scale) {
  json result = error_metrics(scale);
  result["halo"] = halo();
  result["halo"]["outer"] = {{"near", halo()}};
  result["halo"]["inner"] = {{"near", halo()}, {"far", halo()}};
  for (const char* channel : {"r", "g", "b"}) {
    result["channels"][channel] = error_metrics(scale);
    result["channels"][channel]["halo"] = result["halo"];
  }
  result["flip"] = 0.01;
  return result;
}

json run(const std::string& label, double scale, int passes) {
  const std::string stem = "maps/front.skin." + label;
  return {{"scene", "plane"},
          {"view", "front"},
          {"profile", "skin"},
          {"method", label},
          {"label", label},
          {"title", kHostileName},
          {"source", "baseline"},
          {"settings", {{"taps", 13}}},
          {"truth", "front/skin/euclidean-normalised"},
          {"distinguishable", scale > 0.001},
          {"metrics", metrics(scale)},
          {"own_target",
           {{"metric", "geodesic"},
            {"normalised", true},
            {"r_max_mm", nullptr},
            {"truth", nullptr},
            {"metrics", nullptr},
            {"metrics_reason", "no geodesic truth"}}},
          {"extra_targets",
           {{{"metric", "geodesic"},
             {"normalised", true},
             {"r_max_mm", nullptr},
             {"truth", "front/skin/geodesic-normalised"},
             {"distinguishable", scale > 0.001},
             {"metrics", error_metrics(scale)}}}},
          {"profile_error",
           {{"truth", "front/skin/profile-itself-normalised"},
            {"distinguishable", true},
            {"metrics", metrics(1.5 * scale)},
            {"convolution", {{"distinguishable", scale > 0.001}, {"metrics", metrics(scale)}}}}},
          {"cost",
           {{"frame_ms", {{"median", 2.0}, {"min", 1.5}, {"max", 2.5}, {"repeats", 3}}},
            {"setup_ms", 1.0},
            {"passes", passes},
            {"fetches_per_pixel", 13.0 * passes},
            {"bytes_per_pixel", 208.0}}},
          {"files",
           {{"picture", stem + ".png"},
            {"magnitude", stem + ".abs.png"},
            {"signed", stem + ".signed.png"},
            {"exr", stem + ".exr"}}}};
}

// A profile that says what it approximates.
json fit_error() {
  return {{"view", "front"},
          {"profile", "skin"},
          {"fit", "front/skin/euclidean-normalised"},
          {"truth", "front/skin/profile-itself-normalised"},
          {"distinguishable", true},
          {"metrics", metrics(0.02)},
          {"files", {{"signed", "maps/front.skin.truth.profile.signed.png"}}}};
}

json truth_of_the_profile(const json& truth) {
  json itself = truth;
  itself.erase("files");
  itself["id"] = "front/skin/profile-itself-normalised";
  itself["of"] = {{"model", "classical-dipole"}, {"title", kHostileName}, {"albedo", {0.8, 0.5, 0.2}}};
  itself["radial_check"] = {{"points", 32}, {"max_difference", 1e-6}, {"allowed", 1e-4}};
  return itself;
}

json sample_results() {
  const json truth = {
      {"id", "front/skin/euclidean-normalised"},
      {"view", "front"},
      {"profile", "skin"},
      {"metric", "euclidean"},
      {"normalised", true},
      {"r_max_mm", nullptr},
      {"seconds", 1.0},
      {"points", 12},
      {"uncertainty", 3e-5},
      {"low_mass_pixels", 1},
      {"certificate",
       {{"audited", 12},
        {"classes", {{"random", 6}, {"shadow_edge", 3}, {"mask_edge", 0}, {"cut_locus", 3}}},
        {"max_error", 1e-5},
        {"tolerance", 1e-4},
        {"tail_bound", 2e-5},
        {"open_share_95", 0.2}}},
      {"files", {{"picture", "maps/front.skin.truth.png"}, {"exr", "maps/front.skin.truth.exr"}}}};
  json skipped = run("texture-space", 0.1, 1);
  for (const char* key :
       {"metrics", "own_target", "extra_targets", "profile_error", "cost", "files", "distinguishable"})
    skipped.erase(key);
  skipped["skipped"] = "this method needs UVs, and the mesh has none";
  return {
      {"schema", "truescatter-results-1"},
      {"experiment",
       {{"name", kHostileName}, {"question", kHostileName}, {"expectation", ""}, {"source", ""}}},
      {"scene",
       {{"mesh", "plane"},
        {"triangles", 2},
        {"uv", nullptr},
        {"largest_irradiance", 1.0},
        {"irradiance_residual", {{"mean", 0.001}, {"p99", 0.01}, {"tolerance", 0.02}, {"floor_mm", 0.4}}}}},
      {"profiles",
       {{{"name", "skin"},
         {"title", kHostileName},
         {"widest_std_dev_mm", 0.25},
         {"r_max_mm", nullptr},
         {"gaussians", {{{"variance_mm2", {0.0625, 0.0625, 0.0625}}, {"weight", {1.0, 1.0, 1.0}}}}}}}},
      {"views",
       {{{"name", "front"},
         {"width_px", 4},
         {"height_px", 3},
         {"skin_pixels", 12},
         {"median_skin_depth_mm", 500.0},
         {"mm_per_px", 0.3},
         {"files", {{"irradiance", "maps/front.irradiance.png"}}}}}},
      {"truths", {truth, truth_of_the_profile(truth)}},
      {"fit_errors", {fit_error()}},
      {"runs", {run("none", 0.1, 0), run("blur", 0.05, 2), run("perfect", 1e-6, 3), skipped}},
      {"maps", {{"range", 0.2}, {"quantity", "luminance"}, {"exposure", 1.0}}},
      {"provenance", {{"version", "0.1.0"}, {"gl_renderer", "llvmpipe"}, {"rasteriser_threads", 2}}},
      {"exceeded", {kHostileName}}};
}

const std::vector<std::string> kPictures = {
    "front.irradiance",       "front.skin.truth",       "front.skin.none",          "front.skin.none.abs",
    "front.skin.none.signed", "front.skin.blur",        "front.skin.blur.abs",      "front.skin.blur.signed",
    "front.skin.perfect",     "front.skin.perfect.abs", "front.skin.perfect.signed"};

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size()))
    ++count;
  return count;
}

class ReportTest : public testing::Test {
 protected:
  ReportTest() {
    const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = std::filesystem::temp_directory_path() /
              ("truescatter-report-test-" + std::to_string(::getpid()) + "-" + test + " <a & 'b' \"c\">");
    std::filesystem::create_directories(folder_ / "maps");
  }
  ~ReportTest() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  // Every picture differs from every other.
  void write_pictures(int width = 4, int height = 3) const {
    for (std::size_t i = 0; i < kPictures.size(); ++i) {
      write_png(folder_ / "maps" / (kPictures[i] + ".png"),
                Image(width, height, 3, 0.05F * static_cast<float>(i)));
    }
  }
  void write_results(const json& results) const {
    write_text_file(folder_ / "results.json", results.dump(1));
  }

  std::string report() const {
    write_report(folder_);
    return read_text_file(folder_ / "report.html");
  }
  // The page as a program built without plotly.js writes it.
  std::string report_without_plotly() const {
    std::string page = report();
    const std::size_t from = page.find(kPlotlyBlock);
    if (from != std::string::npos) page.erase(from, page.find("</script>", from) + 9 - from);
    return page;
  }
  static constexpr const char* kPlotlyBlock = "<script id=\"plotly\">";

  // The JSON of a script block of the page.
  static json block(const std::string& page, const std::string& id) {
    const std::string start = "<script type=\"application/json\" id=\"" + id + "\">";
    const std::size_t from = page.find(start) + start.size();
    return json::parse(page.substr(from, page.find("</script>", from) - from));
  }

  // That writing fails as an input error whose message holds `part`.
  void expect_input_error(const std::string& part) const {
    try {
      write_report(folder_);
      FAIL() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::input);
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
    EXPECT_FALSE(std::filesystem::exists(folder_ / "report.html"));
  }

  std::filesystem::path folder_;
};

TEST_F(ReportTest, NeedsNothingBesideItself) {
  write_pictures();
  write_results(sample_results());
  // plotly.js names the sites of its authors and of formats; that it asks none is the browser's test.
  const std::string page = report_without_plotly();
  for (const char* reference : {"http://", "https://", "src=\"", "@import", "url(maps", "<link"}) {
    EXPECT_EQ(occurrences(page, reference), 0U) << reference;
  }
}

TEST_F(ReportTest, HoldsPlotlyOnceWithItsLicenceWhereItWasBuiltWithIt) {
  write_pictures();
  write_results(sample_results());
  const std::string page = report();
  const std::size_t blocks = TRUESCATTER_HAS_PLOTLY ? 1 : 0;
  EXPECT_EQ(occurrences(page, kPlotlyBlock), blocks);
  EXPECT_EQ(occurrences(page, "* plotly.js (basic - minified) v"), blocks);
  EXPECT_EQ(occurrences(page, "THE SOFTWARE IS PROVIDED \"AS IS\""), blocks);
  // Nothing in it ends its block early: the page's own five follow.
  EXPECT_EQ(occurrences(page, "</script>"), 5 + blocks);
  EXPECT_EQ(occurrences(page, "<!--"), 0U);
}

TEST_F(ReportTest, HoldsTheResultsUnchanged) {
  write_pictures();
  const json results = sample_results();
  write_results(results);
  EXPECT_EQ(block(report(), "results"), results);
}

TEST_F(ReportTest, HostileNamesStayText) {
  write_pictures();
  write_results(sample_results());
  const std::string page = report_without_plotly();
  // The page's own five blocks: the error mark, results, pictures, values, scripts.
  EXPECT_EQ(occurrences(page, "</script>"), 5U);
  EXPECT_EQ(occurrences(page, "<!--"), 0U);
  EXPECT_NE(page.find("<title>a &lt;b&gt; &amp; &quot;c&quot; &#39;d&#39; &lt;/script&gt;"),
            std::string::npos);
  // A placeholder in the data is data.
  EXPECT_EQ(occurrences(page, "function write_report"), 0U);
  EXPECT_EQ(occurrences(page, "const results = JSON.parse"), 1U);
}

TEST_F(ReportTest, HoldsEachPictureOnce) {
  write_pictures();
  write_results(sample_results());
  const std::string page = report();
  const json pictures = block(page, "pictures");
  ASSERT_EQ(pictures["data"].size(), kPictures.size());
  ASSERT_EQ(pictures["files"].size(), kPictures.size());
  for (const json& uri : pictures["data"]) EXPECT_EQ(occurrences(page, uri.get<std::string>()), 1U);
}

TEST_F(ReportTest, HoldsEqualPicturesOnce) {
  write_pictures();
  std::filesystem::copy_file(folder_ / "maps/front.irradiance.png", folder_ / "maps/front.skin.none.png",
                             std::filesystem::copy_options::overwrite_existing);
  write_results(sample_results());
  const json pictures = block(report(), "pictures");
  EXPECT_EQ(pictures["data"].size(), kPictures.size() - 1);
  EXPECT_EQ(pictures["files"]["maps/front.irradiance.png"]["data"],
            pictures["files"]["maps/front.skin.none.png"]["data"]);
}

// What a strip shows small is no reason for a report to fail, or to grow without end.
TEST_F(ReportTest, HoldsBuffersThatAreThereUpToALimit) {
  write_pictures();
  json results = sample_results();
  std::mt19937 generator(1);
  for (int i = 0; i < 60; ++i) {
    const std::string name = "passes/" + std::to_string(i) + ".png";
    results["views"][0]["files"]["buffers"].push_back({{"name", std::to_string(i)}, {"png", name}});
    if (i == 3) continue;
    Image noise(200, 200, 3);  // 120 KB, which nothing compresses: 160 KB in the page
    for (float& value : noise.data()) value = static_cast<float>(generator() % 256) / 255.0F;
    std::filesystem::create_directories(folder_ / "passes");
    write_png(folder_ / name, noise);
  }
  write_results(results);
  const json files = block(report(), "pictures")["files"];
  EXPECT_TRUE(files.contains("passes/0.png"));
  EXPECT_FALSE(files.contains("passes/3.png"));
  EXPECT_TRUE(files.contains("passes/4.png"));
  EXPECT_FALSE(files.contains("passes/59.png"));
  for (const std::string& picture : kPictures)
    EXPECT_TRUE(files.contains("maps/" + picture + ".png")) << picture;
}

TEST_F(ReportTest, KeepsThePictureBytes) {
  write_pictures();
  write_results(sample_results());
  const json pictures = block(report(), "pictures");
  // A PNG begins with 89 50 4e 47 0d 0a 1a 0a, of which the first six bytes are "iVBORw0K" in base 64.
  for (const json& uri : pictures["data"])
    EXPECT_EQ(uri.get<std::string>().rfind("data:image/png;base64,iVBORw0K", 0), 0U);
}

TEST_F(ReportTest, ScalesLargePicturesDown) {
  write_pictures(1280, 6);
  write_results(sample_results());
  const json pictures = block(report(), "pictures");
  EXPECT_EQ(pictures["files"]["maps/front.skin.truth.png"]["width"], 1280);
  EXPECT_EQ(pictures["files"]["maps/front.skin.truth.png"]["height"], 6);
  // Bytes 16 to 23 of a PNG are its size, 640 = 0x280 and 3; bytes 18 to 23 are characters 24 to 31 in
  // base 64.
  const std::string uri = pictures["data"][0];
  const std::size_t text = uri.find(',') + 1;
  EXPECT_EQ(uri.substr(text + 24, 8), "AoAAAAAD");
}

TEST_F(ReportTest, WritesAgainOverAnOldReport) {
  write_pictures();
  write_results(sample_results());
  const std::string first = report();
  EXPECT_EQ(report(), first);
}

TEST_F(ReportTest, MissingResultsAreAnInputError) { expect_input_error("results.json"); }

TEST_F(ReportTest, BrokenJsonIsAnInputError) {
  write_text_file(folder_ / "results.json", "{\"schema\": NaN}");
  expect_input_error("results.json");
}

TEST_F(ReportTest, UnknownSchemaIsAnInputError) {
  json results = sample_results();
  results["schema"] = "truescatter-results-99";
  write_results(results);
  expect_input_error("truescatter-results-99");
  write_text_file(folder_ / "results.json", "[1, 2]");
  expect_input_error("schema");
}

TEST_F(ReportTest, MissingPictureIsAnInputError) {
  write_pictures();
  write_results(sample_results());
  std::filesystem::remove(folder_ / "maps/front.skin.blur.abs.png");
  expect_input_error("front.skin.blur.abs.png");
}

TEST_F(ReportTest, PictureOutsideTheFolderIsAnInputError) {
  write_pictures();
  json results = sample_results();
  results["runs"][0]["files"]["picture"] = "../secret.png";
  write_results(results);
  expect_input_error("../secret.png");
}

TEST_F(ReportTest, MalformedGroupIsAnInputError) {
  write_pictures();
  json results = sample_results();
  results["runs"] = {{{"files", 3}}};
  write_results(results);
  expect_input_error("results.json");
}

}  // namespace
}  // namespace truescatter
