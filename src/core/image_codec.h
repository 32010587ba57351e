#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace truescatter {

// Pictures of every format, by OpenImageIO, in a library of their own beside the program,
// libtruescatter_images.so. With all that it can read OpenImageIO takes 240 libraries with it, 0.4 s at each
// start: image_io.cpp, the only user, opens it for the first picture that it cannot read by itself
// (plain_pictures.h).

// What a picture's file says of itself.
struct PictureHeader {
  int width = 0;
  int height = 0;
  int depth = 0;
  std::vector<std::string> channels;
  bool is_float = false;
  std::map<std::string, std::string> texts;
};

struct ImageCodec {
  // Returns what is wrong; empty: nothing. `storage` takes the header and gives the place of width x height x
  // channels floats, or null where the header is all that is wanted; what it throws passes through.
  std::string (*decode)(const std::filesystem::path& path,
                        const std::function<float*(const PictureHeader&)>& storage);
};

inline constexpr const char* kImageCodecFile = "libtruescatter_images.so";
// `const ImageCodec* ()`, extern "C".
inline constexpr const char* kImageCodecFunction = "truescatter_image_codec";

}  // namespace truescatter
