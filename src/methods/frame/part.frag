// One channel of the frame by itself: the skin mask, or with DEPTH the distance along the view axis in mm (0 where
// nothing is seen).
SAMPLER(frame);

void main() {
  vec4 texel = read_texel(frame, ivec2(gl_FragCoord.xy));
#ifdef DEPTH
  result = vec4(-texel.z);
#else
  result = vec4(texel.a);
#endif
  WRITE_COUNTS;
}
