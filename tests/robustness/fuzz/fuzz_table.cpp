// Tables: the first byte chooses irradiance, points or mask of a square of two triangles, a measured profile, or
// a profile's layers; the rest is the file.
#include "experiment/truth_files.h"
#include "fuzzed_file.h"
#include "profile/layered.h"
#include "profile/table_profile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace truescatter;
  if (size == 0) return 0;
  const std::filesystem::path file =
      fuzz::fuzzed_file("fuzzed.csv", fuzz::text_of(data + 1, size - 1));
  TruthFiles files{fuzz::fuzzed_file("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"),
                   fuzz::fuzzed_file("light.csv", "r,g,b\n1,1,1\n1,0,0\n0,1,0\n0,0,1\n"),
                   fuzz::fuzzed_file("points.csv", "face,b0,b1,b2\n0,0.5,0.25,0.25\n"), {}};
  switch (data[0] % 5) {
    case 0:
      files.irradiance = file;
      break;
    case 1:
      files.points = file;
      break;
    case 2:
      files.mask = file;
      break;
    case 3:
      fuzz::read_or_refuse(file, [](const std::filesystem::path& path) { read_table_profile(path); });
      return 0;
    default:
      fuzz::read_or_refuse(file, [](const std::filesystem::path& path) { read_layers(path); });
      return 0;
  }
  // A mask may take the skin from under the point, which its own file is then blamed for.
  try {
    read_truth_problem(files);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::input) throw;
    const std::string_view message = error.what();
    if (message.find(".csv") == std::string_view::npos && message.find(".obj") == std::string_view::npos)
      std::abort();
  }
  return 0;
}
