#include "gpu/context.h"

#include <GL/osmesa.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <thread>

#include "core/error.h"

namespace truescatter::gpu {

struct Context::Handle {
  OSMesaContext context = nullptr;
  std::array<unsigned char, 4 * 16 * 16> default_framebuffer{};

  Handle() = default;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (context != nullptr) OSMesaDestroyContext(context);
  }
};

namespace {

template <typename Function>
void load(Function& function, const char* name) {
  function = reinterpret_cast<Function>(OSMesaGetProcAddress(name));
  if (function == nullptr) throw_run_error("OpenGL: the driver has no {}", name);
}

// llvmpipe takes LP_NUM_THREADS, else one thread per core (at most 32).
int llvmpipe_threads() {
  const char* set = std::getenv("LP_NUM_THREADS");
  if (set != nullptr) return std::max(1, std::atoi(set));
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 32);
}

}  // namespace

Context::Context() : handle_(std::make_unique<Handle>()) {
  static constexpr std::array<int, 9> kAttributes = {OSMESA_FORMAT,
                                                     OSMESA_RGBA,
                                                     OSMESA_PROFILE,
                                                     OSMESA_CORE_PROFILE,
                                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                                     4,
                                                     OSMESA_CONTEXT_MINOR_VERSION,
                                                     5,
                                                     0};
  handle_->context = OSMesaCreateContextAttribs(kAttributes.data(), nullptr);
  if (handle_->context == nullptr) throw_run_error("OSMesa: cannot create an OpenGL 4.5 core context");
  if (OSMesaMakeCurrent(handle_->context, handle_->default_framebuffer.data(), GL_UNSIGNED_BYTE, 16, 16) !=
      GL_TRUE) {
    throw_run_error("OSMesa: cannot make the context current");
  }
#define TRUESCATTER_LOAD(Type, Name) load(gl_.Name, "gl" #Name);
  TRUESCATTER_GL_FUNCTIONS(TRUESCATTER_LOAD)
#undef TRUESCATTER_LOAD
  renderer_ = reinterpret_cast<const char*>(gl_.GetString(GL_RENDERER));
  version_ = reinterpret_cast<const char*>(gl_.GetString(GL_VERSION));
  if (renderer_.find("llvmpipe") != std::string::npos) rasteriser_threads_ = llvmpipe_threads();
}

Context::~Context() = default;

void Context::check(const char* what) const {
  const GLenum error = gl_.GetError();
  if (error != GL_NO_ERROR) throw_run_error("OpenGL: error 0x{:04X} in {}", error, what);
}

}  // namespace truescatter::gpu
