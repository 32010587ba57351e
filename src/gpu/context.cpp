#include "gpu/context.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>
#include <thread>

#include "core/error.h"
#include "gpu/platform.h"

namespace truescatter::gpu {
namespace {

template <typename Function>
void load(const Platform& platform, Function& function, const char* name) {
  function = reinterpret_cast<Function>(platform.find(name));
  if (function == nullptr) throw_run_error("OpenGL: the driver has no {}", name);
}

// llvmpipe takes LP_NUM_THREADS, else one thread per core (at most 32).
int llvmpipe_threads() {
  const char* set = std::getenv("LP_NUM_THREADS");
  if (set != nullptr) return std::max(1, std::atoi(set));
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 32);
}

// By Mesa's names for its rasterisers.
bool names_software(std::string_view renderer) {
  static constexpr std::array<std::string_view, 4> kNames = {"llvmpipe", "softpipe", "swrast", "SWR"};
  return std::any_of(kNames.begin(), kNames.end(),
                     [&](std::string_view name) { return renderer.find(name) != std::string_view::npos; });
}

}  // namespace

std::string_view name_of(Backend backend) { return backend == Backend::egl ? "egl" : "osmesa"; }

Context::Context(Backend backend)
    : backend_(backend), platform_(backend == Backend::egl ? make_egl_platform() : make_osmesa_platform()) {
#define TRUESCATTER_LOAD(Type, Name) load(*platform_, gl_.Name, "gl" #Name);
  TRUESCATTER_GL_FUNCTIONS(TRUESCATTER_LOAD)
#undef TRUESCATTER_LOAD
  renderer_ = reinterpret_cast<const char*>(gl_.GetString(GL_RENDERER));
  version_ = reinterpret_cast<const char*>(gl_.GetString(GL_VERSION));
  software_ = names_software(renderer_);
  if (renderer_.find("llvmpipe") != std::string::npos) rasteriser_threads_ = llvmpipe_threads();
}

Context::~Context() = default;

void Context::check(const char* what) const {
  const GLenum error = gl_.GetError();
  if (error != GL_NO_ERROR) throw_run_error("OpenGL: error 0x{:04X} in {}", error, what);
}

}  // namespace truescatter::gpu
