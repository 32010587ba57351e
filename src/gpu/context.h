#pragma once

#include <memory>
#include <string>

#include "gpu/gl_functions.h"

namespace truescatter::gpu {

// An off-screen OpenGL 4.5 core context on OSMesa (software, no display needed). It is current on the thread
// that made it, and everything made from it is used and destroyed on that thread, before it.
// Throws Error (run) when the driver refuses.
class Context {
 public:
  Context();
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const GlFunctions& gl() const { return gl_; }
  const std::string& renderer() const { return renderer_; }
  const std::string& version() const { return version_; }
  // Threads of the software rasteriser (0: not a software rasteriser).
  int rasteriser_threads() const { return rasteriser_threads_; }

  // Throws Error (run) naming `what` if OpenGL has recorded an error since the last call.
  void check(const char* what) const;
  // Waits until all that was submitted is done.
  void finish() const { gl_.Finish(); }

 private:
  struct Handle;
  std::unique_ptr<Handle> handle_;
  GlFunctions gl_;
  std::string renderer_;
  std::string version_;
  int rasteriser_threads_ = 0;
};

}  // namespace truescatter::gpu
