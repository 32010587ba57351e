#pragma once

#include <memory>

namespace truescatter::gpu {

// What holds an OpenGL 4.5 core context that is current on the thread that made it, and finds its entry
// points.
class Platform {
 public:
  using Function = void (*)();

  Platform() = default;
  virtual ~Platform() = default;
  Platform(const Platform&) = delete;
  Platform& operator=(const Platform&) = delete;

  // Null where the driver has no such function.
  virtual Function find(const char* name) const = 0;
};

// Each throws Error (run) when the driver refuses.
std::unique_ptr<Platform> make_osmesa_platform();
std::unique_ptr<Platform> make_egl_platform();

}  // namespace truescatter::gpu
