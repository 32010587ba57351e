#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/image_codec.h"

namespace truescatter {

// A picture to write.
struct EncodeRequest {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;  // of a PNG their number alone counts
  const void* pixels = nullptr;       // interleaved, row 0 at the top: floats of an EXR, bytes of a PNG
  std::map<std::string, std::string> texts;
};

// The two formats that truescatter writes, by their own libraries: most runs read and write no others, and do
// without what reads all of them (image_codec.h).

// EXR: 32-bit floats, ZIP-compressed scan lines. PNG: 8 bits, of 1, 3 or 4 channels, which are not multiplied
// by the fourth; texts as tEXt chunks. Returns what is wrong; empty: nothing.
std::string encode_exr(const EncodeRequest& request, std::vector<unsigned char>& encoded);
std::string encode_png(const EncodeRequest& request, std::vector<unsigned char>& encoded);

// Reads an EXR of scan lines whose channels are all 16- or 32-bit floats of full resolution; whose
// channels' names OpenImageIO orders plainly: by layer, and in it R, G, B, A or X, Y, Z before others. They
// come in that order. False for every other file and for a broken one, whose error is for image_codec.h to
// find; `storage` may have been called. What it throws passes through.
bool decode_plain_exr(const std::filesystem::path& path,
                      const std::function<float*(const PictureHeader&)>& storage);

// The size of a PNG by its header; 0 x 0 of what is none.
struct PictureSize {
  int width = 0;
  int height = 0;
};
PictureSize png_size(const std::filesystem::path& path);

}  // namespace truescatter
