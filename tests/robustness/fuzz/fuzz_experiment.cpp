// Experiments: any text is refused at its place, or is an experiment that can be written out and read again.
#include "config/experiment_spec.h"
#include "fuzzed_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace truescatter;
  const std::filesystem::path file = fuzz::fuzzed_file("e.toml", fuzz::text_of(data, size));
  fuzz::read_or_refuse(file, [](const std::filesystem::path& path) {
    const ExperimentSpec spec = read_experiment(path);
    const std::string resolved = to_toml(spec);
    const ExperimentSpec again = read_experiment(fuzz::fuzzed_file("resolved.toml", resolved));
    if (to_toml(again) != resolved) std::abort();
  });
  return 0;
}
