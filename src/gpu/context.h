#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "gpu/gl_functions.h"

namespace truescatter::gpu {

class Platform;

// Where a context comes from. Neither needs a display: OSMesa is a software rasteriser; EGL takes the first
// device that has OpenGL 4.5, a GPU where there is one.
enum class Backend { osmesa, egl };
std::string_view name_of(Backend backend);

// An off-screen OpenGL 4.5 core context. It is current on the thread that made it, and everything made from
// it is used and destroyed on that thread, before it; a thread has one at a time. Throws Error (run) when the
// driver refuses.
class Context {
 public:
  explicit Context(Backend backend = Backend::osmesa);
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const GlFunctions& gl() const { return gl_; }
  Backend backend() const { return backend_; }
  const std::string& renderer() const { return renderer_; }
  const std::string& version() const { return version_; }
  // Whether the renderer is a software rasteriser.
  bool is_software() const { return software_; }
  // Threads of the software rasteriser (0: not a software rasteriser).
  int rasteriser_threads() const { return rasteriser_threads_; }

  // Throws Error (run) naming `what` if OpenGL has recorded an error since the last call.
  void check(const char* what) const;
  // Waits until all that was submitted is done.
  void finish() const { gl_.Finish(); }

 private:
  Backend backend_;
  std::unique_ptr<Platform> platform_;
  GlFunctions gl_;
  std::string renderer_;
  std::string version_;
  bool software_ = false;
  int rasteriser_threads_ = 0;
};

}  // namespace truescatter::gpu
