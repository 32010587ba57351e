// The picture for a person: what leaves the surface by scattering, times what of the albedo comes after it (Yang et
// al. section II; the walkthrough's MIX), and what is reflected off it, exposed and brought to the display by the tone
// curve of composite/tone.h. Every method's exitance and the truth go through this one pass. Light is in units of
// irradiance: an exitance B of a diffuse surface has the radiance B / pi, so the radiance of the reflection comes here
// times pi. The result is linear; sRGB encoding is that of the picture's file.
layout(location = 0) out vec4 result;

uniform sampler2D exitance;
uniform sampler2D albedo;
uniform sampler2D specular;
uniform float exposure;

vec3 tone(vec3 light) {
  vec3 x = max(light, vec3(0.0));
#ifdef FILMIC
  return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
#else
  return min(x, vec3(1.0));
#endif
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec3 light = texelFetch(exitance, p, 0).rgb * texelFetch(albedo, p, 0).rgb + texelFetch(specular, p, 0).rgb;
  result = vec4(tone(exposure * light), 1.0);
}
