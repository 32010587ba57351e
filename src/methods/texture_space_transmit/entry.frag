// Of every pixel, where its light enters the body: uv (rg), the distance to it in texture space in mm (b), and whether
// there is such a place (a).
SAMPLER(position);    // view space
SAMPLER(surface_uv);
SAMPLER(shadow_map);
SAMPLER(stretch);
uniform mat4 view_to_light;
uniform float mean_texels_per_mm;  // > 0: the stretch map is off
uniform float texture_size;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  result = vec4(0.0);
  if (is_drawn(p)) {
    vec3 at_mm = (view_to_light * vec4(read_texel(position, p).xyz, 1.0)).xyz;
    ivec2 q = shadow_texel(at_mm, textureSize(shadow_map, 0));
    if (q.x >= 0) {
      vec4 entry = read_texel(shadow_map, q);
      if (entry.a > 0.0) {
        vec2 uv = read_texel(surface_uv, p).xy;
        float texels_per_mm = mean_texels_per_mm;
        if (texels_per_mm == 0.0) texels_per_mm = dot(read_linear(stretch, uv).xy, vec2(0.5));
        float distance_mm = length(uv - entry.yz) * texture_size / max(texels_per_mm, 1e-6);
        result = vec4(entry.yz, distance_mm, 1.0);
      }
    }
  }
  WRITE_COUNTS;
}
