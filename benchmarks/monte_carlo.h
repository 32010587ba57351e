#pragma once

#include <memory>
#include <random>

#include "lit_mesh.h"

namespace truescatter::benchmarks {

// What a renderer would do: probe the surface around a point with rays and weigh what they hit (King, Kulla,
// Conty & Fajardo, "BSSRDF importance sampling", SIGGRAPH talks 2013). A radius is drawn from the Gaussian
// itself on a disc whose axis is the normal (half of the probes) or one of two tangents; a ray along the axis
// crosses the sphere of the largest radius; every hit counts G(d) I over the density with which any of the
// three axes would have found it. Unbiased but for what lies beyond the largest radius (6 s: 1.5e-8).
class MonteCarlo {
 public:
  explicit MonteCarlo(const LitMesh& scene);
  ~MonteCarlo();
  MonteCarlo(const MonteCarlo&) = delete;
  MonteCarlo& operator=(const MonteCarlo&) = delete;

  Vec4d convolve(const MeshPoint& point, double std_dev_mm, int probes, std::mt19937_64& generator) const;

 private:
  struct Handles;
  const LitMesh& scene_;
  std::unique_ptr<Handles> handles_;
};

}  // namespace truescatter::benchmarks
