// screen-octree: what the view sees of front and back as sample points, gathered by an octree in software, as Mikkelsen
// 2010, section 3, describes the implementation of van Lommel 2007, with the hierarchy of Jensen & Buhler 2002. This
// shader draws the back buffer; the rest is screen_octree.cpp and sample_octree.h.
//
// Source: two irradiance buffers from the camera, front-facing primitives in the first and back-facing ones in the
// second; the surface point behind every pixel goes into an octree, and the rest is done in software as by Jensen &
// Buhler: for each pixel the octree is walked from its root; a voxel that the point is not in, and whose samples' area A
// is seen from it under a solid angle A / |x - P|^2 below a bound, counts as one sample (the sum of their areas, their
// mean position P and mean light); otherwise its children are walked, and a leaf's samples count one by one.
// Each Gaussian is sum of A_i G(|x - x_i|) I_i, A_i = w(p) dp (equation 2; screen_integral.frag), over
// sum of A_i G: w_0 I + sum_j w_j times that.
//
// What the sources leave open, and what we take: the reflectance is the profile's sum of Gaussians, each walked in the
// same way; each is divided by its own weights, so that sampling density makes no brightness (`sum` = raw does not);
// mean positions are weighted by area (Jensen & Buhler: by irradiance, which differs from channel to channel); a voxel
// is split until it holds 8 samples; the back buffer keeps the nearest of several back faces, as a depth buffer does,
// behind what the front buffer holds; samples beyond 5.5 s are passed over. No r_max: the tree replaces it.
//
// Settings: solid_angle (bound in steradians; 0: every sample by itself), sum (normalised | raw).
// Own target: Euclidean, whole surface, normalised or raw, not cut off.
// Cost: two passes over the geometry; three pictures read back, a tree of up to two samples a pixel and its walk on the
//   CPU's threads: in the frame's time, not among the counted reads.
// Fails: concave shapes and overlaps (two layers); faces seen edge on, which neither buffer samples; Gaussians narrower
//   than the distance of samples (raw: the sample itself, far too bright; normalised: unblurred); voxels taken as
//   a sample while the Gaussian changes across them: the solid angle knows nothing of s.
//
// Limits. Constant: normalised, in double precision, then stored in single: 1e-6. Identity: all other samples are out
// of reach: 1e-6. Mirror: the same samples in a mirrored tree, but for those on a voxel's face to rounding: 1e-5.
SAMPLER(front);  // position of the front buffer; a: 0 where there is none
in vec3 v_position_mm;
flat in vec3 v_face_normal;
in vec3 v_irradiance;
flat in float v_skin;

void main() {
  vec4 before = read_texel(front, ivec2(gl_FragCoord.xy));
  bool faces_away = dot(v_face_normal, v_position_mm) > 0.0;
  if (!faces_away || before.a == 0.0 || v_position_mm.z >= before.z * (1.0 + 4e-6)) discard;
#ifdef BACK_POSITION
  result = vec4(v_position_mm, 1.0);
#else
  float w = v_skin * area_weight(v_position_mm, v_face_normal);
  result = w * vec4(v_irradiance, 1.0);
#endif
  WRITE_COUNTS;
}
