// Adds one blurred level, times its weight, to the result (by blending), on skin.
SAMPLER(irradiance);
SAMPLER(level);
uniform vec3 weight;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  bool skin = read_texel(irradiance, p).a > 0.0;
  result = skin ? vec4(weight * read_texel(level, p).rgb, 0.0) : vec4(0.0);
  WRITE_COUNTS;
}
