// Equation 4 of Mikkelsen 2010: irradiance with the area weight w(p) of equation 2 premultiplied, rgb; w(p) in a,
// 0 off the skin. With CONSTANT_AREA w(p) is 1.
SAMPLER(irradiance);
SAMPLER(position);
SAMPLER(face_normal);

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 light = read_texel(irradiance, p);
  result = vec4(0.0);
  if (light.a > 0.0) {
#ifdef CONSTANT_AREA
    float w = 1.0;
#else
    float w = area_weight(read_texel(position, p).xyz, read_texel(face_normal, p).xyz);
#endif
    result = w * vec4(light.rgb, 1.0);
  }
  WRITE_COUNTS;
}
