#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace truescatter {

// Pictures' file formats, by OpenImageIO, in a library of their own beside the program,
// libtruescatter_images.so. With all that it can read OpenImageIO takes 240 libraries with it, 0.4 s at each
// start: image_io.cpp, the only user, opens it when the first picture is read or written.

// A picture to write: 32-bit floats, or bytes as they are.
struct EncodeRequest {
  std::string file_name;  // whose extension names the format
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;
  bool is_float = false;
  const void* pixels = nullptr;  // interleaved, row 0 at the top
  std::map<std::string, std::string> texts;
};

// What a picture's file says of itself.
struct PictureHeader {
  int width = 0;
  int height = 0;
  int depth = 0;
  std::vector<std::string> channels;
  bool is_float = false;
  std::map<std::string, std::string> texts;
};

// Each returns what is wrong; empty: nothing.
struct ImageCodec {
  std::string (*encode)(const EncodeRequest& request, std::vector<unsigned char>& encoded);
  // `storage` takes the header and gives the place of width x height x channels floats, or null where the
  // header is all that is wanted; what it throws passes through.
  std::string (*decode)(const std::filesystem::path& path,
                        const std::function<float*(const PictureHeader&)>& storage);
};

inline constexpr const char* kImageCodecFile = "libtruescatter_images.so";
// `const ImageCodec* ()`, extern "C".
inline constexpr const char* kImageCodecFunction = "truescatter_image_codec";

}  // namespace truescatter
