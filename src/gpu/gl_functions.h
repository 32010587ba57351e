#pragma once

#include <GL/gl.h>
#include <GL/glext.h>

namespace truescatter::gpu {

// Every OpenGL entry point that the project calls. All are loaded through the context
// (OSMesaGetProcAddress, eglGetProcAddress): other loaders look for a display.
#define TRUESCATTER_GL_FUNCTIONS(X)                            \
  X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                     \
  X(PFNGLATTACHSHADERPROC, AttachShader)                       \
  X(PFNGLBINDBUFFERPROC, BindBuffer)                           \
  X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                 \
  X(decltype(&glBindTexture), BindTexture)                     \
  X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                 \
  X(decltype(&glBlendFunc), BlendFunc)                         \
  X(PFNGLBUFFERDATAPROC, BufferData)                           \
  X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)   \
  X(PFNGLCLEARBUFFERFVPROC, ClearBufferfv)                     \
  X(PFNGLCLEARBUFFERUIVPROC, ClearBufferuiv)                   \
  X(PFNGLCOMPILESHADERPROC, CompileShader)                     \
  X(PFNGLCREATEPROGRAMPROC, CreateProgram)                     \
  X(PFNGLCREATESHADERPROC, CreateShader)                       \
  X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                     \
  X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)           \
  X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                     \
  X(PFNGLDELETESHADERPROC, DeleteShader)                       \
  X(decltype(&glDeleteTextures), DeleteTextures)               \
  X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)           \
  X(decltype(&glDepthFunc), DepthFunc)                         \
  X(decltype(&glDisable), Disable)                             \
  X(decltype(&glDrawArrays), DrawArrays)                       \
  X(PFNGLDRAWBUFFERSPROC, DrawBuffers)                         \
  X(decltype(&glEnable), Enable)                               \
  X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray) \
  X(decltype(&glFinish), Finish)                               \
  X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D)       \
  X(PFNGLGENBUFFERSPROC, GenBuffers)                           \
  X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                 \
  X(decltype(&glGenTextures), GenTextures)                     \
  X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                 \
  X(PFNGLGETACTIVEUNIFORMPROC, GetActiveUniform)               \
  X(decltype(&glGetError), GetError)                           \
  X(decltype(&glGetIntegerv), GetIntegerv)                     \
  X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)             \
  X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                       \
  X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)               \
  X(PFNGLGETSHADERIVPROC, GetShaderiv)                         \
  X(decltype(&glGetString), GetString)                         \
  X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)           \
  X(PFNGLLINKPROGRAMPROC, LinkProgram)                         \
  X(decltype(&glPixelStorei), PixelStorei)                     \
  X(decltype(&glReadBuffer), ReadBuffer)                       \
  X(decltype(&glReadPixels), ReadPixels)                       \
  X(decltype(&glScissor), Scissor)                             \
  X(PFNGLSHADERSOURCEPROC, ShaderSource)                       \
  X(decltype(&glTexImage2D), TexImage2D)                       \
  X(decltype(&glTexParameteri), TexParameteri)                 \
  X(PFNGLUNIFORM1FPROC, Uniform1f)                             \
  X(PFNGLUNIFORM1FVPROC, Uniform1fv)                           \
  X(PFNGLUNIFORM1IPROC, Uniform1i)                             \
  X(PFNGLUNIFORM2FPROC, Uniform2f)                             \
  X(PFNGLUNIFORM2IPROC, Uniform2i)                             \
  X(PFNGLUNIFORM3FPROC, Uniform3f)                             \
  X(PFNGLUNIFORM3FVPROC, Uniform3fv)                           \
  X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)               \
  X(PFNGLUSEPROGRAMPROC, UseProgram)                           \
  X(PFNGLVERTEXATTRIBIPOINTERPROC, VertexAttribIPointer)       \
  X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)         \
  X(decltype(&glViewport), Viewport)

struct GlFunctions {
#define TRUESCATTER_DECLARE(Type, Name) Type Name = nullptr;
  TRUESCATTER_GL_FUNCTIONS(TRUESCATTER_DECLARE)
#undef TRUESCATTER_DECLARE
};

}  // namespace truescatter::gpu
