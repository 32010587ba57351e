// Shared by every pass of every method. All texture reads go through these functions, so that the
// instrumented variant of a shader (never timed) can count them: texels read, and bytes of stored texels.
layout(location = 0) out vec4 result;

#ifdef INSTRUMENT
layout(location = 1) out vec4 counts;  // texel fetches, bytes
float texels_read = 0.0;
#define COUNT_TEXELS(n) texels_read += float(n)
#define WRITE_COUNTS counts = vec4(texels_read, texels_read * 16.0, 0.0, 0.0)
#else
#define COUNT_TEXELS(n)
#define WRITE_COUNTS
#endif

// One texel of a four-channel float texture.
vec4 read_texel(sampler2D image, ivec2 p) {
  COUNT_TEXELS(1);
  return texelFetch(image, p, 0);
}

// A bilinear reading: four texels. The texture's filter must be linear.
vec4 read_linear(sampler2D image, vec2 uv) {
  COUNT_TEXELS(4);
  return textureLod(image, uv, 0.0);
}

bool inside(ivec2 p, ivec2 size) { return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size)); }
