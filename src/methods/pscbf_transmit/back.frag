// The back buffer of pscbf_transmit.frag: of the transmitters, what faces away from the viewer, the nearest of it. BACK_SURFACE writes the
// interpolated normal (rgb) and the view-space z in mm (a), else the irradiance (rgb) and 1 (a).
in vec3 v_position_mm;
flat in vec3 v_face_normal;
in vec3 v_normal;
in vec3 v_irradiance;
flat in float v_skin;
flat in float v_transmits;

void main() {
  if (v_transmits * v_skin == 0.0 || dot(v_face_normal, v_position_mm) <= 0.0) discard;
#ifdef BACK_SURFACE
  result = vec4(normalize(v_normal), v_position_mm.z);
#else
  result = vec4(v_irradiance, 1.0);
#endif
  WRITE_COUNTS;
}
