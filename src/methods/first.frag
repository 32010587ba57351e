// The first layer of a result: the light that leaves where it entered on skin, the plain irradiance elsewhere.
SAMPLER(irradiance);
uniform vec3 delta_weight;

void main() {
  vec4 center = read_texel(irradiance, ivec2(gl_FragCoord.xy));
  result = vec4(center.a > 0.0 ? delta_weight * center.rgb : center.rgb, center.a);
  WRITE_COUNTS;
}
