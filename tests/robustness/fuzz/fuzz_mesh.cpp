// Meshes: the first byte chooses the format, the rest is the file.
#include <array>

#include "fuzzed_file.h"
#include "scene/load_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace truescatter;
  static constexpr std::array<const char*, 3> kNames = {"m.obj", "m.ply", "m.off"};
  if (size == 0) return 0;
  const std::string_view bytes = fuzz::text_of(data + 1, size - 1);
  const std::filesystem::path file = fuzz::fuzzed_file(kNames[data[0] % kNames.size()], bytes);
  fuzz::read_or_refuse(file, [](const std::filesystem::path& path) {
    const Mesh mesh = load_mesh(path, {});
    if (mesh.triangle_count() == 0) std::abort();
    inspect_uvs(mesh);
  });
  return 0;
}
