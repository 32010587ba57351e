#include <GL/osmesa.h>

#include <array>

#include "core/error.h"
#include "gpu/platform.h"

namespace truescatter::gpu {
namespace {

class OsMesaPlatform : public Platform {
 public:
  OsMesaPlatform() {
    static constexpr std::array<int, 9> kAttributes = {OSMESA_FORMAT,
                                                       OSMESA_RGBA,
                                                       OSMESA_PROFILE,
                                                       OSMESA_CORE_PROFILE,
                                                       OSMESA_CONTEXT_MAJOR_VERSION,
                                                       4,
                                                       OSMESA_CONTEXT_MINOR_VERSION,
                                                       5,
                                                       0};
    context_.reset(OSMesaCreateContextAttribs(kAttributes.data(), nullptr));
    if (context_ == nullptr) throw_run_error("OSMesa: cannot create an OpenGL 4.5 core context");
    if (OSMesaMakeCurrent(context_.get(), default_framebuffer_.data(), GL_UNSIGNED_BYTE, 16, 16) != GL_TRUE)
      throw_run_error("OSMesa: cannot make the context current");
  }

  Function find(const char* name) const override { return OSMesaGetProcAddress(name); }

 private:
  struct Destroy {
    void operator()(OSMesaContext context) const { OSMesaDestroyContext(context); }
  };
  std::array<unsigned char, 4 * 16 * 16> default_framebuffer_{};
  std::unique_ptr<osmesa_context, Destroy> context_;
};

}  // namespace

std::unique_ptr<Platform> make_osmesa_platform() { return std::make_unique<OsMesaPlatform>(); }

}  // namespace truescatter::gpu
