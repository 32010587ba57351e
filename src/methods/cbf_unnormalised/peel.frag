// One depth-peeled layer: the nearest surface that lies behind the one before. PEEL_POSITION writes its position (rgb;
// 1 in a), else its irradiance times w(p) and w(p), as weighted.frag does for the first layer.
SAMPLER(previous);  // position of the layer before; a: 0 where there is none
in vec3 v_position_mm;
flat in vec3 v_face_normal;
in vec3 v_irradiance;
flat in float v_skin;

void main() {
  vec4 before = read_texel(previous, ivec2(gl_FragCoord.xy));
  if (before.a == 0.0 || v_position_mm.z >= before.z * (1.0 + 4e-6)) discard;
#ifdef PEEL_POSITION
  result = vec4(v_position_mm, 1.0);
#else
  float w = v_skin * area_weight(v_position_mm, v_face_normal);
  result = w * vec4(v_irradiance, 1.0);
#endif
  WRITE_COUNTS;
}
