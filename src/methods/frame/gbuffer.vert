// The G-buffer, and with UV_SPACE the same attributes laid out in texture space.
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 face_normal;
layout(location = 2) in vec3 normal;
layout(location = 3) in vec3 irradiance;
layout(location = 4) in vec2 uv;
layout(location = 5) in float skin;
layout(location = 6) in float transmits;
layout(location = 7) in float character;

uniform mat4 view;
uniform mat4 projection;

out vec3 v_position_mm;
flat out vec3 v_face_normal;
out vec3 v_normal;
out vec3 v_irradiance;
out vec2 v_uv;
flat out float v_skin;
flat out float v_transmits;
flat out float v_character;
out vec2 v_barycentric;

void main() {
  vec4 p = view * vec4(position_mm, 1.0);
  v_position_mm = p.xyz;
  v_face_normal = mat3(view) * face_normal;
  v_normal = mat3(view) * normal;
  v_irradiance = irradiance;
  v_uv = uv;
  v_skin = skin;
  v_transmits = transmits;
  v_character = character;
  int corner = gl_VertexID % 3;
  v_barycentric = vec2(corner == 1, corner == 2);
#ifdef UV_SPACE
  gl_Position = vec4(uv * 2.0 - 1.0, 0.0, 1.0);
#else
  gl_Position = projection * p;
#endif
}
