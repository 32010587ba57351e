#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/image_codec.h"

namespace truescatter {

// The library beside the program that knows all of pictures' formats (core/image_codec.h): a part of the
// program. Throws Error (run) where it is missing.
std::filesystem::path image_codec_file();

// What it knows; opens it at the first call. Throws Error (run) where it cannot be opened.
const ImageCodec& image_codec();

// One group of channels of an EXR. Channel c is written as "<name>.<suffix c>", with the suffixes
// R, G, B, A (colours), X, Y, Z (`vector`), or as plain "<name>" where there is one channel. An empty name
// gives bare suffixes.
struct ExrLayer {
  std::string name;
  const Image* image = nullptr;
  bool vector = false;
};

// Texts that a picture's file carries beside its pixels, by name: attributes of an EXR, tEXt chunks of a PNG.
using ImageTexts = std::map<std::string, std::string>;

// Writes 32-bit float layers of equal size into one EXR, through a temporary file and a rename.
// Throws Error (run) when the file cannot be written.
void write_exr(const std::filesystem::path& path, const std::vector<ExrLayer>& layers,
               const ImageTexts& texts = {});

// Writes values in [0, 1], taken as they are (encode before), as an 8-bit PNG of 1, 3 or 4 channels.
void write_png(const std::filesystem::path& path, const Image& image, const ImageTexts& texts = {});

// The texts of a file that OpenImageIO knows, and what else of its metadata is text. Throws Error (input)
// that names the file.
ImageTexts read_image_texts(const std::filesystem::path& path);

// Reads any format that OpenImageIO knows. 8- and 16-bit values become [0, 1]; nothing is decoded, and
// colours are not multiplied by alpha. `channel_names` receives the file's names. Throws Error (input) that
// names the file.
Image read_image(const std::filesystem::path& path, std::vector<std::string>* channel_names = nullptr);

// How many values read_image would give, of its header alone; 0 of what it would not read.
double image_values(const std::filesystem::path& path);

// What making a picture out of a file of named layers takes for each pixel, at most: fourteen channels as
// floats, two layers of them, and the bytes that are written.
inline constexpr double kPictureJobBytes = 116.0;

// Reads a picture for its colours, as linear values: whole numbers are taken as sRGB-encoded and decoded, all
// but a fourth channel; floating-point values are linear already. Throws as read_image does.
Image read_linear_colours(const std::filesystem::path& path,
                          std::vector<std::string>* channel_names = nullptr);

// A file with all of its channels, decoded once for however many layers are wanted of it.
struct LayeredImage {
  std::filesystem::path path;
  Image channels;
  std::vector<std::string> names;  // the channels'
};

// Reads a file as read_linear_colours does.
LayeredImage read_layered_image(const std::filesystem::path& path);

// One layer of an EXR: the channels whose name starts with "<layer>.", or where it is empty the bare
// suffixes, which have one letter. Of another format, its colours. Throws Error (input) that names the file
// where it has no such layer.
Image layer_of(const LayeredImage& image_file, const std::string& layer);

// The layer's R, G, B, or its first three channels. Throws Error (input) that names the file too where it has
// fewer, or a value that is not finite.
Image rgb_of(const LayeredImage& image_file, const std::string& layer = "");

// One layer of a file that is read for it alone.
Image read_exr_layer(const std::filesystem::path& path, const std::string& layer);
Image read_rgb(const std::filesystem::path& path, const std::string& layer = "");

}  // namespace truescatter
