// pscbf-mip: one axis of the second version of the pseudo-separable filter (Mikkelsen 2010, section 7), which reads
// one-dimensional mip maps: horizontal ones for the horizontal pass, vertical ones of its result for the vertical.
//
// Source: "horizontal (and subsequently vertical) mip maps", "custom built to take depth discontinuities into account",
// "filtering was done manually in the shader"; the results "roughly the same", execution "significantly slower". All
// else is that of section 5: the bound d', N taps of equal probability for red with weights corrected for green and
// blue, the depth term, the skin's mask, normalisation (pscbf.frag).
//
// What the source leaves open, and what we take:
//   chain   level k halves the axis k times (halve.frag): the mean of two pixels, unless their depths differ by more
//           than gap_mm: then the nearer pixel alone. gap_mm is the profile's widest standard deviation: a step that
//           the depth term itself would let through at exp(-1/2). A texel without skin on one side is the other's.
//   level   log2 of the width in pixels of the tap's bin, the outermost bins ending at r_max; between two levels, both.
//   filter  along the axis between the two texels around the tap, each with its own depth term, dropped off the skin.
// Tap i lies at t_i d'/2 as in pscbf, without rounding to a pixel.
//
// Settings: taps (N, 13), placement (median | centroid), r_max_mm (0: the profile's).
// Own target: normalised, cut off at r_max.
// Cost: up to four reads a tap where pscbf has two, two passes and the chain's 2 + 2/3 reads a pixel for the horizontal
//   chain, and the vertical one's for every term.
// Fails: as pscbf, but for taps below a pixel and gaps between taps: what lies between them is read. Texels and their
//   interpolation spread a bin of width w by up to 0.42 w^2, against the w^2 / 12 that it ought to have: variance is
//   added where bins are wider than a pixel (the outermost is 3 s wide, so wider than the Gaussian asks for); small
//   inner bins lose theirs as before. Texels are dyadic: they do not follow the tap, so the result changes with where
//   the surface lies in the picture. A kept nearer pixel takes the farther one's share.
//
// Limits. Constant: normalised, 1e-6. Identity: within a pixel taps read linearly, off by E|q| s_px = 0.8 s_px times
// the largest step to the next pixel, for each axis: 1.6. Mirror: where the picture's sides are multiples of 2^level (else
// the chains of the two differ); coordinates of some hundred pixels round to 1e-5 px, under steps of up to 1: 1e-5,
// and with the sums 2e-5.
SAMPLER(source);
SAMPLER(position);
SAMPLER(normal);
SAMPLER(level0);
SAMPLER(level1);
SAMPLER(level2);
SAMPLER(level3);
SAMPLER(level4);
SAMPLER(level5);
SAMPLER(level6);
SAMPLER(level7);
uniform int levels;
uniform int axis;
uniform float r_max_mm;
uniform float focal_px;
uniform int tap_count;
uniform float tap_offset[MAX_TAPS];  // t_i, in units of d' / 2
uniform float tap_width[MAX_TAPS];   // of its bin, likewise
uniform vec3 tap_weight[MAX_TAPS];   // probability per channel
uniform vec3 depth_factor;           // -1 / 2 s_c^2 per channel

vec4 read_level(int level, ivec2 p) {
  switch (level) {
    case 0: return read_texel(level0, p);
    case 1: return read_texel(level1, p);
    case 2: return read_texel(level2, p);
    case 3: return read_texel(level3, p);
    case 4: return read_texel(level4, p);
    case 5: return read_texel(level5, p);
    case 6: return read_texel(level6, p);
    default: return read_texel(level7, p);
  }
}

vec3 light_sum = vec3(0.0);
vec3 weight_sum = vec3(0.0);

void add_texel(int level, ivec2 p, int along, int size, float depth_mm, vec3 weight) {
  if (along < 0 || along >= size || weight == vec3(0.0)) return;
  vec4 texel = read_level(level, axis == 0 ? ivec2(along, p.y) : ivec2(p.x, along));
  if (texel.a == 0.0) return;
  float step_mm = texel.a - depth_mm;
  vec3 w = weight * exp(step_mm * step_mm * depth_factor);
  light_sum += w * texel.rgb;
  weight_sum += w;
}

void add_linear(int level, ivec2 p, float along_px, float depth_mm, vec3 weight) {
  int full_size = axis == 0 ? textureSize(source, 0).x : textureSize(source, 0).y;
  int size = (full_size + (1 << level) - 1) >> level;
  float coordinate = along_px / float(1 << level) - 0.5;
  float first = floor(coordinate);
  float share = coordinate - first;
  add_texel(level, p, int(first), size, depth_mm, (1.0 - share) * weight);
  add_texel(level, p, int(first) + 1, size, depth_mm, share * weight);
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 center = read_texel(source, p);
  result = center;
  if (center.a > 0.0) {
    vec3 x = read_texel(position, p).xyz;
    float reach_px = disc_half_extent(x, read_texel(normal, p).xyz, axis, r_max_mm) * focal_px;
    for (int i = 0; i < tap_count; ++i) {
      float along_px = float(axis == 0 ? p.x : p.y) + 0.5 + tap_offset[i] * reach_px;
      float exact_level = clamp(log2(max(tap_width[i] * reach_px, 1.0)), 0.0, float(levels - 1));
      int level = int(exact_level);
      float share = exact_level - float(level);
      add_linear(level, p, along_px, -x.z, (1.0 - share) * tap_weight[i]);
      if (share > 0.0) add_linear(level + 1, p, along_px, -x.z, share * tap_weight[i]);
    }
    bvec3 any_weight = greaterThan(weight_sum, vec3(1e-30));
    result = vec4(mix(center.rgb, light_sum / max(weight_sum, vec3(1e-30)), vec3(any_weight)), center.a);
  }
  WRITE_COUNTS;
}
