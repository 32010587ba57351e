// The surface laid out in texture space.
layout(location = 0) in vec3 position_mm;
layout(location = 3) in vec3 irradiance;
layout(location = 4) in vec2 uv;
layout(location = 5) in float skin;

out vec3 v_position_mm;
out vec3 v_irradiance;
flat out float v_skin;

void main() {
  v_position_mm = position_mm;
  v_irradiance = irradiance;
  v_skin = skin;
  gl_Position = vec4(uv * 2.0 - 1.0, 0.0, 1.0);
}
