// The interpolated unit normal in texture space, world space; alpha is 1 on texels whose centre lies on skin.
in vec3 v_normal;
flat in float v_skin;

void main() {
  if (v_skin == 0.0) discard;
  result = vec4(normalize(v_normal), 1.0);
  WRITE_COUNTS;
}
