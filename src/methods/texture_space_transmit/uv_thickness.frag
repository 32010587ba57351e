// Irradiance and thickness in texture space: rgb, and in alpha exp(-decay t), kNone where no light comes through.
SAMPLER(shadow_map);
SAMPLER(surface_normal);  // in texture space
uniform mat4 view;        // world to the light's view space
uniform float decay_per_mm;

in vec3 v_position_mm;  // in the light's view space
in vec3 v_normal;
in vec3 v_irradiance;
flat in float v_skin;

float encoded_thickness() {
  vec3 n = normalize(v_normal);
  float facing = dot(n, towards_light(v_position_mm));
  if (facing > 0.0) return kNone;
  ivec2 p = shadow_texel(v_position_mm, textureSize(shadow_map, 0));
  if (p.x < 0) return kNone;
  vec4 entry = read_texel(shadow_map, p);
  if (entry.a == 0.0) return kNone;
  float thickness_mm = max(light_distance_mm(v_position_mm) - entry.x, 0.0);
#ifdef CORRECTED
  vec3 entry_normal = mat3(view) * read_linear(surface_normal, entry.yz).xyz;
  float opposing = clamp(-dot(entry_normal, n) / max(length(entry_normal), 1e-6), 0.0, 1.0);
  thickness_mm *= mix(1.0, -facing, opposing);
#endif
  return max(exp(-decay_per_mm * thickness_mm), kNone);
}

void main() {
  if (v_skin == 0.0) discard;
  result = vec4(v_irradiance, encoded_thickness());
  WRITE_COUNTS;
}
