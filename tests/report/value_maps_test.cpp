#include "report/value_maps.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.h"
#include "core/image_io.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

using nlohmann::json;

Image waves(int width, int height) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      image.set_rgb(x, y, {std::sin(0.3 * x), 0.7 + 0.01 * y * x, std::cos(0.2 * y) - 0.001 * x});
  }
  return image;
}

double value_of(const QuantizedImage& image, int x, int y, int c) {
  const int code = image.codes.at(static_cast<std::size_t>((c * image.height + y) * image.width + x));
  return image.low + image.step * (code - 1);
}

TEST(QuantizedImage, ReadsBackToHalfAStep) {
  const Image image = waves(23, 17);
  const QuantizedImage stored = quantized(image, Image(23, 17, 1, 1.0F), 1);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 17; ++y) {
      for (int x = 0; x < 23; ++x) {
        // Rounding to the nearest level; what double arithmetic adds is far below a step.
        EXPECT_LE(std::abs(value_of(stored, x, y, c) - image.at(x, y, c)), 0.5001 * stored.step);
      }
    }
  }
}

TEST(QuantizedImage, HasNoValueOutsideOfTheMask) {
  Image image(2, 1, 3, 0.5F);
  image.set_rgb(1, 0, {100.0, 100.0, 100.0});
  Image mask(2, 1, 1, 1.0F);
  mask.at(1, 0, 0) = 0.0F;
  const QuantizedImage stored = quantized(image, mask, 1);
  EXPECT_EQ(stored.codes, (std::vector<std::uint16_t>{1, 0, 1, 0, 1, 0}));
  EXPECT_EQ(stored.low, 0.5);
  EXPECT_EQ(stored.step, 0.0);
}

TEST(QuantizedImage, KeepsEveryStridethPixel) {
  const Image image = waves(7, 5);
  const QuantizedImage stored = quantized(image, Image(7, 5, 1, 1.0F), 3);
  ASSERT_EQ(stored.width, 3);   // columns 0, 3, 6
  ASSERT_EQ(stored.height, 2);  // rows 0, 3
  EXPECT_NEAR(value_of(stored, 2, 1, 1), image.at(6, 3, 1), 0.5001 * stored.step);
}

// What packed() wrote, read by its definition: the codes of plane 0, 1, 2.
std::vector<std::uint16_t> unpacked(const std::string& bytes, int width, int height) {
  const auto count = static_cast<std::size_t>(3 * width * height);
  std::vector<Bytef> plain(2 * count);
  uLongf size = plain.size();
  EXPECT_EQ(uncompress(plain.data(), &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()),
            Z_OK);
  EXPECT_EQ(size, plain.size());
  std::vector<std::uint16_t> codes(count);
  const auto at = [&](int plane, int x, int y) -> std::uint16_t& {
    return codes[static_cast<std::size_t>((plane * height + y) * width + x)];
  };
  std::size_t next = 0;
  for (int plane = 0; plane < 3; ++plane) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x, ++next) {
        const int folded = plain[next] + 256 * plain[count + next];
        const int residual = folded % 2 == 0 ? folded / 2 : -(folded + 1) / 2;
        const int predicted = (x > 0 ? at(plane, x - 1, y) : 0) + (y > 0 ? at(plane, x, y - 1) : 0) -
                              (x > 0 && y > 0 ? at(plane, x - 1, y - 1) : 0);
        at(plane, x, y) = static_cast<std::uint16_t>(predicted + residual);
      }
    }
  }
  return codes;
}

TEST(PackedValues, UnpackToTheSameCodes) {
  const Image image = waves(23, 17);
  Image mask(23, 17, 1, 1.0F);
  for (int x = 0; x < 20; ++x) mask.at(x, x * 3 % 17, 0) = 0.0F;
  const QuantizedImage stored = quantized(image, mask, 1);
  EXPECT_EQ(unpacked(packed(stored), 23, 17), stored.codes);
}

// A folder with one truth, one run and the results that name them.
class EmbeddedValues : public testing::Test {
 protected:
  EmbeddedValues() {
    std::filesystem::create_directories(folder_.path() / "maps");
    const Image image = waves(40, 30);
    const Image mask(40, 30, 1, 1.0F);
    Image mass(40, 30, 1, 1.0F);
    mass.at(4, 2, 0) = 0.49F;
    write_exr(folder_.path() / "maps/truth.exr", {{"", &image}, {"mass", &mass}, {"mask", &mask}});
    write_exr(folder_.path() / "maps/run.exr", {{"", &image}, {"mask", &mask}});
  }
  json values(std::size_t max_bytes = 1'000'000) const {
    return embedded_values(folder_.path(), results_, max_bytes);
  }

  test::TempDir folder_;
  json results_ = {{"truths", {{{"files", {{"exr", "maps/truth.exr"}}}}}},
                   {"runs", {{{"files", {{"exr", "maps/run.exr"}}}}}}};
};

TEST_F(EmbeddedValues, HoldsTruthsAndRunsOnce) {
  results_["runs"].push_back(results_["runs"][0]);
  const json all = values();
  EXPECT_EQ(all["stride"], 1);
  EXPECT_EQ(all["missing"], json::array());
  ASSERT_EQ(all["maps"].size(), 2U);
  EXPECT_EQ(all["maps"]["maps/run.exr"]["width"], 40);
  EXPECT_EQ(all["maps"]["maps/run.exr"]["height"], 30);
  // The truth has no value where its mass is below one half.
  EXPECT_NE(all["maps"]["maps/truth.exr"]["data"], all["maps"]["maps/run.exr"]["data"]);
}

TEST_F(EmbeddedValues, ThinOutUntilTheyFit) {
  const auto size = [](const json& all) {
    std::size_t bytes = 0;
    for (const json& map : all["maps"]) bytes += map["data"].get<std::string>().size();
    return bytes;
  };
  const std::size_t full = size(values());
  const json fewer = values(full - 1);
  EXPECT_EQ(fewer["stride"], 2);
  EXPECT_LE(size(fewer), full - 1);
  EXPECT_EQ(fewer["maps"]["maps/run.exr"]["width"], 20);
}

TEST_F(EmbeddedValues, ListsWhatIsMissing) {
  std::filesystem::remove(folder_.path() / "maps/run.exr");
  const json all = values();
  EXPECT_EQ(all["missing"], json::array({"maps/run.exr"}));
  EXPECT_EQ(all["maps"].size(), 1U);
}

TEST_F(EmbeddedValues, OutsideTheFolderIsAnInputError) {
  results_["runs"][0]["files"]["exr"] = "../run.exr";
  EXPECT_THROW(values(), Error);
}

}  // namespace
}  // namespace truescatter
