in vec3 v_position_mm;
flat in vec3 v_face_normal;
in vec3 v_normal;
in vec3 v_irradiance;
in vec2 v_uv;
flat in float v_skin;
flat in float v_character;
in vec2 v_barycentric;

layout(location = 0) out vec4 position;
layout(location = 1) out vec4 face_normal;
layout(location = 2) out vec4 normal;
layout(location = 3) out vec4 irradiance;
layout(location = 4) out vec2 uv;
layout(location = 5) out uvec4 surface_id;
layout(location = 6) out float character;

void main() {
  position = vec4(v_position_mm, 1.0);
  face_normal = vec4(v_face_normal, 0.0);
  normal = vec4(normalize(v_normal), 0.0);
  irradiance = vec4(v_irradiance, v_skin);
  uv = v_uv;
  character = v_skin * v_character;
  surface_id = uvec4(gl_PrimitiveID + 1, floatBitsToUint(v_barycentric.x), floatBitsToUint(v_barycentric.y), 0u);
}
