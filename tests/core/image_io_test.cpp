#include "core/image_io.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>

#include "core/file.h"
#include "core/plain_pictures.h"
#include "support/error_of.h"
#include "support/temp_dir.h"

namespace truescatter {
namespace {

namespace fs = std::filesystem;
using test::error_of;
using test::TempDir;

// Any finite bit pattern: zeros of both signs, denormals, the largest values.
Image random_bits(int width, int height, int channels, unsigned seed) {
  Image image(width, height, channels);
  std::mt19937 generator(seed);
  for (float& v : image.data()) {
    do {
      v = std::bit_cast<float>(static_cast<std::uint32_t>(generator()));
    } while (!std::isfinite(v));
  }
  image.data()[0] = -0.0F;
  return image;
}

void expect_same_bits(const Image& actual, const Image& expected) {
  ASSERT_EQ(actual.width(), expected.width());
  ASSERT_EQ(actual.height(), expected.height());
  ASSERT_EQ(actual.channels(), expected.channels());
  for (std::size_t i = 0; i < expected.data().size(); ++i) {
    ASSERT_EQ(std::bit_cast<std::uint32_t>(actual.data()[i]),
              std::bit_cast<std::uint32_t>(expected.data()[i]))
        << i;
  }
}

TEST(Exr, EveryLayerComesBackToTheBit) {
  const TempDir folder;
  const fs::path path = folder.path() / "a.exr";
  const Image plain = random_bits(7, 5, 3, 1);
  const Image error = random_bits(7, 5, 3, 2);
  const Image position = random_bits(7, 5, 3, 3);
  const Image mask = random_bits(7, 5, 1, 4);
  const Image rgba = random_bits(7, 5, 4, 5);
  write_exr(
      path,
      {{"", &plain}, {"error", &error}, {"position", &position, true}, {"mask", &mask}, {"four", &rgba}});
  EXPECT_EQ(folder.names(), std::vector<std::string>{"a.exr"});
  expect_same_bits(read_exr_layer(path, "error"), error);
  expect_same_bits(read_exr_layer(path, "position"), position);
  expect_same_bits(read_exr_layer(path, "mask"), mask);
  expect_same_bits(read_exr_layer(path, "four"), rgba);
}

// "mask" has no dot in its name, but it is a layer of its own and no plain channel.
TEST(Exr, ThePlainLayerHoldsNoNamedOne) {
  const TempDir folder;
  const fs::path path = folder.path() / "a.exr";
  const Image plain = random_bits(4, 3, 3, 1);
  const Image alone = random_bits(4, 3, 1, 2);
  write_exr(path, {{"alone", &alone}, {"", &plain}});
  expect_same_bits(read_exr_layer(path, ""), plain);
}

TEST(Exr, ChannelsHaveTheirDocumentedNames) {
  const TempDir folder;
  const fs::path path = folder.path() / "a.exr";
  const Image three(2, 2, 3, 1.0F);
  const Image one(2, 2, 1, 1.0F);
  write_exr(path, {{"", &three}, {"error", &three}, {"position", &three, true}, {"mask", &one}});
  std::vector<std::string> names;
  read_image(path, &names);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"B", "G", "R", "error.B", "error.G", "error.R", "mask",
                                             "position.X", "position.Y", "position.Z"}));
}

// What reads every format and what reads those of truescatter's own files find the same: values to the bit,
// channels in one order, texts.
TEST(Exr, IsReadAlikeByBothReaders) {
  const TempDir folder;
  const fs::path path = folder.path() / "a.exr";
  const Image three = random_bits(6, 5, 3, 1);
  const Image four = random_bits(6, 5, 4, 2);
  const Image one = random_bits(6, 5, 1, 3);
  const Image vector = random_bits(6, 5, 3, 4);
  const std::vector<std::vector<ExrLayer>> files = {
      {{"", &three}},
      {{"", &four}, {"error", &three}, {"mask", &one}},
      {{"visible", &one}, {"position", &vector, true}, {"b", &four}, {"a", &three}},
      {{"one", &one}},
      {{"vector", &four, true}, {"", &three}, {"zebra", &one}, {"Lake", &one}, {"alpine", &one}}};
  for (const std::vector<ExrLayer>& layers : files) {
    write_exr(path, layers, {{"Software", "truescatter 1"}, {"truescatter:experiment", "abc"}});
    PictureHeader header;
    Image image;
    const auto storage = [&](const PictureHeader& found) {
      header = found;
      image = Image(found.width, found.height, static_cast<int>(found.channels.size()));
      return image.data().data();
    };
    ASSERT_EQ(image_codec().decode(path, storage), "");
    const PictureHeader by_all = header;
    const Image pixels = image;
    ASSERT_TRUE(decode_plain_exr(path, storage));
    EXPECT_EQ(header.channels, by_all.channels);
    expect_same_bits(image, pixels);
    for (const char* text : {"Software", "truescatter:experiment"})
      EXPECT_EQ(header.texts.at(text), by_all.texts.at(text));
    EXPECT_TRUE(header.is_float && by_all.is_float);
  }
}

// Order among these names is OpenImageIO's to know.
TEST(Exr, LeavesUnusualNamesToWhoReadsAllFiles) {
  const TempDir folder;
  const fs::path path = folder.path() / "a.exr";
  const Image one = random_bits(6, 5, 1, 3);
  const Image four = random_bits(6, 5, 4, 2);
  const auto storage = [](const PictureHeader&) { return static_cast<float*>(nullptr); };
  for (const std::vector<ExrLayer>& layers : {std::vector<ExrLayer>{{"", &one}, {"mask", &one}},
                                              {{"", &four}, {"Z", &one}},
                                              {{"r", &one}, {"g", &one}}}) {
    write_exr(path, layers);
    EXPECT_FALSE(decode_plain_exr(path, storage));
    EXPECT_EQ(read_image(path).channels(), layers.front().image->channels() + 1);
  }
}

TEST(WritePng, HasItsSizeInItsHeader) {
  const TempDir folder;
  write_png(folder.path() / "a.png", Image(70000, 3, 1, 0.5F));
  EXPECT_EQ(png_size(folder.path() / "a.png").width, 70000);
  EXPECT_EQ(png_size(folder.path() / "a.png").height, 3);
  EXPECT_EQ(png_size(folder.write("b.png", "no picture at all, but as long as a header of one")).width, 0);
  EXPECT_EQ(png_size(folder.path() / "none.png").width, 0);
}

TEST(Exr, AMissingLayerNamesTheFileAndWhatThereIs) {
  const TempDir folder;
  const fs::path path = folder.path() / "a.exr";
  const Image one(2, 2, 1, 1.0F);
  write_exr(path, {{"mask", &one}});
  const auto error = error_of([&] { read_exr_layer(path, "mas"); });
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->kind(), ErrorKind::input);
  EXPECT_EQ(error->what(), path.string() + ": no layer 'mas'; the file's channels are mask");
}

TEST(Exr, FailsWhereItCannotBeWrittenAndLeavesNothing) {
  const TempDir folder;
  const Image one(2, 2, 1, 1.0F);
  const fs::path nowhere = folder.path() / "none" / "a.exr";
  const auto missing = error_of([&] { write_exr(nowhere, {{"mask", &one}}); });
  ASSERT_TRUE(missing.has_value());
  EXPECT_EQ(missing->kind(), ErrorKind::run);
  EXPECT_NE(std::string(missing->what()).find(nowhere.string()), std::string::npos) << missing->what();

  const fs::path taken = folder.path() / "taken.exr";
  fs::create_directories(taken / "inside");
  const auto over = error_of([&] { write_exr(taken, {{"mask", &one}}); });
  ASSERT_TRUE(over.has_value());
  EXPECT_EQ(over->kind(), ErrorKind::run);
  EXPECT_EQ(folder.names(), std::vector<std::string>{"taken.exr"});
}

class Png : public testing::TestWithParam<int> {};

// A code k is read as the float nearest to k/255, and written by rounding 255 v: |255 v - k| < 1/2.
TEST_P(Png, EveryCodeSurvivesInEveryChannel) {
  const TempDir folder;
  const int channels = GetParam();
  Image image(16, 16, channels);
  for (std::size_t i = 0; i < image.data().size(); ++i) {
    image.data()[i] = static_cast<float>((i * 37U) % 256U) / 255.0F;  // 37 is odd: all 256 codes occur
  }
  write_png(folder.path() / "a.png", image);
  const Image read = read_image(folder.path() / "a.png");
  ASSERT_EQ(read.channels(), channels);
  for (std::size_t i = 0; i < image.data().size(); ++i) {
    ASSERT_EQ(std::lround(255.0F * read.data()[i]), static_cast<long>((i * 37U) % 256U)) << i;
    // One rounding in each direction, on a value of at most 1.
    ASSERT_NEAR(read.data()[i], image.data()[i], 2 * std::numeric_limits<float>::epsilon()) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Channels, Png, testing::Values(1, 3, 4));

TEST(WritePng, ClampsAndRoundsToTheNearestCode) {
  const TempDir folder;
  Image image(4, 1, 1);
  image.at(0, 0, 0) = -1.0F;
  image.at(1, 0, 0) = 2.0F;
  image.at(2, 0, 0) = 100.4F / 255.0F;
  image.at(3, 0, 0) = 100.6F / 255.0F;
  write_png(folder.path() / "a.png", image);
  const Image read = read_image(folder.path() / "a.png");
  EXPECT_EQ(read.at(0, 0, 0), 0.0F);
  EXPECT_EQ(read.at(1, 0, 0), 1.0F);
  EXPECT_EQ(std::lround(255.0F * read.at(2, 0, 0)), 100);
  EXPECT_EQ(std::lround(255.0F * read.at(3, 0, 0)), 101);
}

void expect_unreadable(const fs::path& path) {
  const auto error = error_of([&] { read_image(path); });
  ASSERT_TRUE(error.has_value()) << path;
  EXPECT_EQ(error->kind(), ErrorKind::input);
  EXPECT_EQ(std::string(error->what()).rfind(path.string() + ": ", 0), 0U) << error->what();
}

// 188 of 255 is 0.5029 in linear light, by IEC 61966-2-1: ((188/255 + 0.055) / 1.055)^2.4.
TEST(ReadLinearColours, DecodesWholeNumbersAndKeepsFloats) {
  const TempDir folder;
  const Image image(2, 1, 4, static_cast<float>(188.0 / 255.0));
  write_png(folder.path() / "a.png", image);
  const Image decoded = read_linear_colours(folder.path() / "a.png");
  ASSERT_EQ(decoded.channels(), 4);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(decoded.at(1, 0, c), 0.5029, 5e-5);
  EXPECT_EQ(decoded.at(1, 0, 3), image.at(1, 0, 3));  // not a colour
  write_exr(folder.path() / "a.exr", {{"", &image}});
  EXPECT_EQ(read_linear_colours(folder.path() / "a.exr").at(1, 0, 0), image.at(1, 0, 0));
}

// A header is a few bytes, and could ask for any memory. Radiance's: a text, then the pixels.
TEST(ImageValues, AreToldByTheHeader) {
  const test::TempDir folder;
  const Image image(5, 3, 3, 0.5F);
  write_exr(folder.path() / "a.exr", {{"", &image}});
  EXPECT_EQ(image_values(folder.path() / "a.exr"), 45.0);
  EXPECT_EQ(image_values(folder.path() / "none.exr"), 0.0);
}

TEST(ReadImage, AsksForNoMoreThanAFileCanHold) {
  const test::TempDir folder;
  const auto refusal = [&](const std::string& size) {
    const std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\nabcd";
    const auto error = test::error_of([&] { read_image(folder.write("p.hdr", text)); });
    return error ? std::string(error->what()) : std::string("read");
  };
  EXPECT_NE(refusal("-Y 40000 +X 40000")
                .find("p.hdr: the image is 40000 x 40000 with 3 channels; at most 2^30 values"),
            std::string::npos)
      << refusal("-Y 40000 +X 40000");
  EXPECT_NE(refusal("-Y 1 +X 400000").find("400000 wide with 3 channels; at most 2^20 values in a row"),
            std::string::npos)
      << refusal("-Y 1 +X 400000");
  EXPECT_NE(refusal("-Y 4000 +X 4000").find("which a file of 55 bytes cannot hold"), std::string::npos)
      << refusal("-Y 4000 +X 4000");
}

// A string of 0x72000000 bytes in a file of a few hundred.
TEST(ReadImage, AsksForNoLongerAttributeThanAFileHolds) {
  const test::TempDir folder;
  const Image image(5, 3, 3, 0.5F);
  write_exr(folder.path() / "a.exr", {{"", &image}}, {{"comments", "short"}});
  std::string bytes = read_text_file(folder.path() / "a.exr");
  const std::string before = std::string("comments\0string\0", 16);
  const std::size_t size = bytes.find(before);
  ASSERT_NE(size, std::string::npos);
  bytes[size + before.size() + 3] = '\x72';
  const auto error = test::error_of([&] { read_image(folder.write("b.exr", bytes)); });
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(std::string(error->what())
                .find("b.exr: cannot read this image: attribute 'comments' is of 1912602629 bytes, and "),
            std::string::npos)
      << error->what();
  EXPECT_EQ(image_values(folder.path() / "b.exr"), 0.0);
}

// OpenEXR reads these values by their types: what a wrong length makes of the rest of the header is not
// looked at.
TEST(ReadImage, TakesAttributesOfTheirTypesLengthsAlone) {
  const test::TempDir folder;
  const Image image(5, 3, 3, 0.5F);
  write_exr(folder.path() / "a.exr", {{"", &image}});
  const std::string whole = read_text_file(folder.path() / "a.exr");
  for (const std::string& before :
       {std::string("channels\0chlist\0", 16), std::string("dataWindow\0box2i\0", 17)}) {
    std::string bytes = whole;
    const std::size_t size = bytes.find(before);
    ASSERT_NE(size, std::string::npos);
    bytes[size + before.size()] = static_cast<char>(bytes[size + before.size()] + 1);
    const auto error = test::error_of([&] { read_image(folder.write("b.exr", bytes)); });
    ASSERT_TRUE(error.has_value());
    EXPECT_NE(std::string(error->what()).find("which is not what its type "), std::string::npos)
        << error->what();
  }
}

TEST(ReadImage, ErrorsBeginWithTheFile) {
  const TempDir folder;
  expect_unreadable(folder.path() / "none.png");
  expect_unreadable(folder.path());
  expect_unreadable(folder.write("text.png", "this is no picture"));
  expect_unreadable(folder.write("empty.exr", ""));
  expect_unreadable(folder.write("unknown.truescatter", "x"));
}

TEST(ReadImage, RefusesATruncatedFile) {
  const TempDir folder;
  const fs::path whole = folder.path() / "whole.exr";
  const Image image = random_bits(64, 64, 3, 9);
  write_exr(whole, {{"", &image}});
  const fs::path half = folder.path() / "half.exr";
  fs::copy_file(whole, half);
  fs::resize_file(half, fs::file_size(whole) / 2);
  expect_unreadable(half);
}

}  // namespace
}  // namespace truescatter
