// Irradiance in texture space; alpha is 1 on texels whose centre lies on skin.
in vec3 v_position_mm;
in vec3 v_irradiance;
flat in float v_skin;

void main() {
  if (v_skin == 0.0) discard;
  result = vec4(v_irradiance, 1.0);
  WRITE_COUNTS;
}
