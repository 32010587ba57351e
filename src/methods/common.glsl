// Shared by every pass of every method. Samplers are declared by SAMPLER(name), and all texture reads go through
// the functions below, so that the instrumented variant of a shader (never timed) can count them: texels read, and
// bytes of stored texels. A sampler passed on to a function cannot be counted: read where it is declared.
layout(location = 0) out vec4 result;

#ifdef INSTRUMENT
layout(location = 1) out vec4 counts;  // texel fetches, bytes
float texels_read = 0.0;
float bytes_read = 0.0;
// Binding a texture sets how many bytes a texel of its format has (gpu::Program::set).
#define SAMPLER(name) uniform sampler2D name; uniform float name##_texel_bytes
#define WRITE_COUNTS counts = vec4(texels_read, bytes_read, 0.0, 0.0)
void count_texels(float texels, float texel_bytes) {
  texels_read += texels;
  bytes_read += texels * texel_bytes;
}
vec4 counted_texel(sampler2D image, ivec2 p, float texel_bytes) {
  count_texels(1.0, texel_bytes);
  return texelFetch(image, p, 0);
}
vec4 counted_linear(sampler2D image, vec2 uv, float texel_bytes) {
  count_texels(4.0, texel_bytes);
  return textureLod(image, uv, 0.0);
}
#define read_texel(image, p) counted_texel(image, p, image##_texel_bytes)
#define read_linear(image, uv) counted_linear(image, uv, image##_texel_bytes)
#else
#define SAMPLER(name) uniform sampler2D name
#define WRITE_COUNTS
// One texel.
vec4 read_texel(sampler2D image, ivec2 p) { return texelFetch(image, p, 0); }
// A bilinear reading: four texels. The texture's filter must be linear.
vec4 read_linear(sampler2D image, vec2 uv) { return textureLod(image, uv, 0.0); }
#endif

bool inside(ivec2 p, ivec2 size) { return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size)); }
