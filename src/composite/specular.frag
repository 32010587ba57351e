// Specular reflection off skin by Kelemen & Szirmay-Kalos 2001, as d'Eon & Luebke and the walkthrough use it: one pass
// for each light, added up. Everything is in view space; light is pi times the reflected radiance (see composite.frag).
//
// From a light without size: pi rho_s f I,  f = D(N.H, m) F(V.H) / (h.h),  h = L + V not made unit length. I is that
// light's irradiance, shadows, max(0, N.L) and the mapped normal N included. (The walkthrough multiplies by a "correction
// factor" of 50, because what it reads of its table is not scaled; here nothing is.)
//
// From an environment of nine terms, L(w) = sum L_i y_i(w): pi rho_s int L f (N.w) dw is exact by the lobe's moments
// up to second order, tabulated over N.V and m (composite/specular.h); times the share of the irradiance that occlusion
// leaves there, which is an approximation: occlusion is not known by direction.
layout(location = 0) out vec4 result;

uniform sampler2D position;   // rgb: mm; a: 1 where a surface is seen
uniform sampler2D normal;     // rgb: the mapped unit normal
uniform sampler2D gloss;      // r: intensity rho_s; g: roughness m; 0 on what is not skin
uniform sampler2D light_map;  // rgb: the light's irradiance, or the share that occlusion leaves of it

const float pi = 3.14159265358979;
const float least_roughness = 0.1;
const float roughness_span = 2.302585093;  // ln(1 / 0.1)

// The row of a table over ln m, as a texture coordinate: values lie at texels' centres.
vec2 table_uv(sampler2D table, float column, float m) {
  vec2 last = vec2(textureSize(table, 0) - 1);
  vec2 at = vec2(clamp(column, 0.0, 1.0), clamp(log(m / least_roughness) / roughness_span, 0.0, 1.0));
  return (at * last + 0.5) / (last + 1.0);
}

#ifdef ENVIRONMENT
uniform sampler2D moments_first;
uniform sampler2D moments_second;
uniform vec3 environment[9];   // L_i, world space
uniform mat4 view_to_world;

vec3 reflected(vec3 n_view, vec3 v_view, float m) {
  vec3 n = mat3(view_to_world) * n_view;
  vec3 v = mat3(view_to_world) * v_view;
  float n_v = clamp(dot(n, v), 0.0, 1.0);
  vec3 x = v - dot(n, v) * n;
  // Seen along N there is no such way; nor do the moments prefer one.
  if (dot(x, x) < 1e-12) x = cross(n, abs(n.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0));
  x = normalize(x);
  vec3 y = cross(n, x);
  vec4 a = textureLod(moments_first, table_uv(moments_first, n_v, m), 0.0);
  vec4 b = textureLod(moments_second, table_uv(moments_second, n_v, m), 0.0);
  // The lobe's integrals of w and of w w^T.
  vec3 first = a.y * x + a.z * n;
  float yy = a.x - a.w - b.x;
  mat3 second = a.w * outerProduct(x, x) + yy * outerProduct(y, y) + b.x * outerProduct(n, n) +
                b.y * (outerProduct(x, n) + outerProduct(n, x));
  const float k0 = 0.282094792, k1 = 0.488602512, k2 = 1.092548431, k20 = 0.315391565;
  vec3 sum = environment[0] * k0 * a.x;
  sum += k1 * (environment[1] * first.y + environment[2] * first.z + environment[3] * first.x);
  sum += k2 * (environment[4] * second[0][1] + environment[5] * second[1][2] + environment[7] * second[0][2]);
  sum += k20 * environment[6] * (3.0 * second[2][2] - a.x);
  sum += 0.5 * k2 * environment[8] * (second[0][0] - second[1][1]);
  return max(sum, vec3(0.0));
}
#else
uniform sampler2D beckmann;
uniform vec3 light;    // towards it, unit length; of a point light its position, mm
uniform float is_point;
uniform float f0;

float distribution(float n_h, float m) {
  float value = textureLod(beckmann, table_uv(beckmann, n_h, m), 0.0).r;
#ifdef POWER
  return pow(2.0 * value, 10.0);
#else
  return exp(value);
#endif
}

vec3 reflected(vec3 n, vec3 v, float m, vec3 at_mm) {
  vec3 l = is_point > 0.5 ? normalize(light - at_mm) : light;
  vec3 h = l + v;
  float h_h = max(dot(h, h), 1e-6);
  vec3 half_way = h * inversesqrt(h_h);
  float n_h = dot(n, half_way);
  if (dot(n, l) <= 0.0 || n_h <= 0.0) return vec3(0.0);
  float rest = 1.0 - clamp(dot(half_way, v), 0.0, 1.0);
  float fifth = rest * rest * rest * rest * rest;
  float fresnel = fifth + (1.0 - fifth) * f0;
  return vec3(distribution(n_h, m) * fresnel / h_h);
}
#endif

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 at = texelFetch(position, p, 0);
  vec2 skin = texelFetch(gloss, p, 0).rg;
  result = vec4(0.0);
  if (at.a == 0.0 || skin.r == 0.0) return;
  vec3 n = texelFetch(normal, p, 0).rgb;
  vec3 v = normalize(-at.xyz);
#ifdef ENVIRONMENT
  vec3 lobe = reflected(n, v, skin.g);
#else
  vec3 lobe = reflected(n, v, skin.g, at.xyz);
#endif
  result = vec4(pi * skin.r * lobe * texelFetch(light_map, p, 0).rgb, 1.0);
}
