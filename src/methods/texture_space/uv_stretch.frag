// The stretch map: texels per millimetre along u and v. Position is linear on a triangle, so the derivatives
// are exact, helper pixels included.
in vec3 v_position_mm;
in vec3 v_irradiance;
flat in float v_skin;

void main() {
  if (v_skin == 0.0) discard;
  result = vec4(1.0 / max(length(dFdx(v_position_mm)), 1e-6), 1.0 / max(length(dFdy(v_position_mm)), 1e-6), 0.0, 1.0);
  WRITE_COUNTS;
}
