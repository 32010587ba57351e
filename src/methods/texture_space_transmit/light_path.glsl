// The light's view space (LightView in light_view.h): where a point lies in the light's picture, how far the light has
// come, and where it comes from.
uniform mat4 projection;   // the light's
uniform int point_light;  // 1; 0: directional

// Negative outside the picture.
ivec2 shadow_texel(vec3 position_mm, ivec2 size) {
  vec4 clip = projection * vec4(position_mm, 1.0);
  if (clip.w <= 0.0 || any(greaterThan(abs(clip.xy), vec2(clip.w)))) return ivec2(-1);
  return min(ivec2((clip.xy / clip.w * 0.5 + 0.5) * vec2(size)), size - 1);
}

float light_distance_mm(vec3 position_mm) { return point_light != 0 ? length(position_mm) : -position_mm.z; }

vec3 towards_light(vec3 position_mm) { return point_light != 0 ? -normalize(position_mm) : vec3(0.0, 0.0, 1.0); }
