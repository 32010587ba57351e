// Pictures: the first byte chooses the format, the rest is the file.
#include <array>

#include "core/image_io.h"
#include "fuzzed_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace truescatter;
  static constexpr std::array<const char*, 3> kNames = {"p.exr", "p.png", "p.hdr"};
  if (size == 0) return 0;
  const std::string_view bytes = fuzz::text_of(data + 1, size - 1);
  const std::filesystem::path file = fuzz::fuzzed_file(kNames[data[0] % kNames.size()], bytes);
  fuzz::read_or_refuse(file, [](const std::filesystem::path& path) { read_linear_colours(path); });
  fuzz::read_or_refuse(file, [](const std::filesystem::path& path) { read_rgb(path); });
  return 0;
}
