// The finest level of pscbf_mip.frag's chain: rgb the source's, a the depth in mm (> 0), 0 off the skin.
SAMPLER(source);  // a: 1 on skin
SAMPLER(position);

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 light = read_texel(source, p);
  result = light.a > 0.0 ? vec4(light.rgb, -read_texel(position, p).z) : vec4(0.0);
  WRITE_COUNTS;
}
