// One axis of a Gaussian in screen space, as wide as its millimetres are at the pixel's own depth, over skin alone.
//
// Given by the harness (all declared here, none needed): see experiments/own-shader.toml.
SAMPLER(previous);
SAMPLER(mask);
SAMPLER(depth);
uniform float focal_px;
uniform float std_dev_mm;
uniform float width;  // a setting of the experiment
uniform int axis;     // a setting of the pass

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 center = read_texel(previous, p);
  result = center;
  if (read_texel(mask, p).r == 0.0) return;
  float std_dev_px = max(1e-3, width * std_dev_mm * focal_px / read_texel(depth, p).r);
  int radius = int(ceil(4.0 * std_dev_px));
  ivec2 direction = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
  vec3 sum = vec3(0.0);
  float weights = 0.0;
  for (int i = -radius; i <= radius; ++i) {
    ivec2 q = p + i * direction;
    if (!inside(q, textureSize(previous, 0)) || read_texel(mask, q).r == 0.0) continue;
    float w = exp(-0.5 * float(i * i) / (std_dev_px * std_dev_px));
    sum += w * read_texel(previous, q).rgb;
    weights += w;
  }
  result = vec4(sum / weights, center.a);
}
