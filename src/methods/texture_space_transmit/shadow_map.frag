// The translucent shadow map: of what the light meets first, the distance from it in mm (r), uv (gb) and whether light
// gets in (a: 1 on skin that transmits).
in vec3 v_position_mm;
in vec2 v_uv;
flat in float v_skin;
flat in float v_transmits;

void main() {
  result = vec4(light_distance_mm(v_position_mm), v_uv, v_skin * v_transmits);
  WRITE_COUNTS;
}
