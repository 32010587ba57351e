#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "gpu/platform.h"

#ifdef __SANITIZE_ADDRESS__
#include <dlfcn.h>
#include <link.h>
#endif

namespace truescatter::gpu {
namespace {

bool has_extension(EGLDisplay display, const std::string& name) {
  const char* names = eglQueryString(display, EGL_EXTENSIONS);
  std::istringstream words(names != nullptr ? names : "");
  for (std::string word; words >> word;) {
    if (word == name) return true;
  }
  return false;
}

template <typename Function>
Function entry(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

// The displays that need no window system, the best first: Mesa lists its software rasteriser after all
// devices.
std::vector<EGLDisplay> displays() {
  std::vector<EGLDisplay> found;
  const auto query = entry<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  if (query != nullptr && has_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device")) {
    std::array<EGLDeviceEXT, 32> devices{};
    EGLint count = 0;
    if (query(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_FALSE) count = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
      found.push_back(eglGetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
  }
  if (has_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    found.push_back(eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  found.erase(std::remove(found.begin(), found.end(), EGL_NO_DISPLAY), found.end());
  return found;
}

// eglTerminate unloads Mesa's driver, and the leak sanitizer cannot name afterwards what that has left
// (tests/lsan.supp does, by its file): under it the driver stays.
void keep_driver_for_the_leak_sanitizer() {
#ifdef __SANITIZE_ADDRESS__
  std::vector<std::string> drivers;
  dl_iterate_phdr(
      [](dl_phdr_info* module, std::size_t, void* names) {
        if (std::string_view(module->dlpi_name).ends_with("_dri.so"))
          static_cast<std::vector<std::string>*>(names)->emplace_back(module->dlpi_name);
        return 0;
      },
      &drivers);
  for (const std::string& driver : drivers) dlopen(driver.c_str(), RTLD_LAZY | RTLD_NODELETE);
#endif
}

// A display with a current context on it, or the reason why there is none.
class EglPlatform : public Platform {
 public:
  explicit EglPlatform(EGLDisplay display) : display_(display) {
    failure_ = start();
    if (!failure_.empty()) failure_ += fmt::format(" (EGL error 0x{:04X})", eglGetError());
  }
  ~EglPlatform() override {
    if (!initialised_) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
    eglTerminate(display_);
  }

  // Empty: the context is current.
  const std::string& failure() const { return failure_; }

  Function find(const char* name) const override { return eglGetProcAddress(name); }

 private:
  std::string start() {
    initialised_ = eglInitialize(display_, nullptr, nullptr) == EGL_TRUE;
    if (!initialised_) return "cannot initialise the display";
    if (!has_extension(display_, "EGL_KHR_surfaceless_context")) return "no EGL_KHR_surfaceless_context";
    if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) return "no OpenGL";
    static constexpr std::array<EGLint, 5> kConfig = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE,
                                                      EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint configs = 0;
    if (eglChooseConfig(display_, kConfig.data(), &config, 1, &configs) != EGL_TRUE || configs < 1)
      return "no configuration for OpenGL";
    static constexpr std::array<EGLint, 7> kContext = {EGL_CONTEXT_MAJOR_VERSION,
                                                       4,
                                                       EGL_CONTEXT_MINOR_VERSION,
                                                       5,
                                                       EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                                       EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                                       EGL_NONE};
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, kContext.data());
    if (context_ == EGL_NO_CONTEXT) return "cannot create an OpenGL 4.5 core context";
    if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE)
      return "cannot make the context current";
    keep_driver_for_the_leak_sanitizer();
    return "";
  }

  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
  bool initialised_ = false;
  std::string failure_;
};

}  // namespace

std::unique_ptr<Platform> make_egl_platform() {
  std::vector<std::string> failures;
  for (EGLDisplay display : displays()) {
    auto platform = std::make_unique<EglPlatform>(display);
    if (platform->failure().empty()) return platform;
    failures.push_back(platform->failure());
  }
  throw_run_error("EGL: no OpenGL 4.5 core context without a window: {}",
                  failures.empty()
                      ? "no device and no surfaceless platform; is a driver installed (libegl-mesa0)?"
                      : fmt::format("{}", fmt::join(failures, "; ")));
}

}  // namespace truescatter::gpu
