#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "irradiance/mesh_point.h"
#include "profile/profile.h"
#include "scene/mesh.h"
#include "truth/surface.h"

namespace truescatter {

// The files of the command `truth` (README, Commands).
struct TruthFiles {
  std::filesystem::path mesh;        // triangles, mm; any format that load_mesh reads
  std::filesystem::path irradiance;  // CSV: r,g,b; one row per vertex of the file, in file order
  std::filesystem::path points;      // CSV: face,b0,b1,b2; faces count from 0 in file order
  std::filesystem::path mask;        // CSV: 0 or 1 per triangle, 1 where there is skin; empty: all of it
};

// What the files say, ready for an engine.
struct TruthProblem {
  Mesh mesh;               // every triangle, in file order; coincident positions are one vertex
  std::vector<bool> skin;  // of each triangle
  Surface surface;         // the skin's triangles, in file order, those that share an edge in one component
  std::vector<std::size_t> mesh_triangle;  // of each of the surface's triangles
  std::vector<MeshPoint> places;           // of each point, on `mesh`; barycentrics in [0, 1], of sum 1
  std::vector<SurfacePoint> points;        // the same, as the Euclidean engines want them
};

// Reads and checks the files.
//
// What a mesh may lack is not mended but means what it says: triangles without area add nothing; edges of
// three triangles, opposite windings and the two sides of a sheet without thickness (the same corners in the
// opposite order) are all surface, and add their light (geodesics refuse them: IntrinsicMesh). Vertices that
// are close, but do not coincide, are apart.
//
// Throws Error (input) that names file, line, value and rule: what the loaders and CsvReader refuse; a face
// that is no triangle; two faces of skin with the same corners in the same order, for S is a set and their
// light would count twice; a T-junction that parts two components of skin, for light stays within one; a row
// too many or missing; irradiance that differs between vertices at one position; a point on a face that is
// not there or not skin, or whose barycentrics lie outside [0, 1] or do not sum to 1, by more than 1e-9.
TruthProblem read_truth_problem(const TruthFiles& files);

// OUT.csv: header point,sigma,r,g,b,mass; points in input order (from 0) and within each the layers as given;
// raw values, 17 significant digits. `values` as the engines return them; Error (run) where one is not
// finite.
std::string truth_csv(std::span<const TruthLayer> layers, const TruthValues& values);

// OUT.csv of a sum of Gaussians w_i: header point,r,g,b,normalised_r,...,mass_r,...; one row per point, of
// sum w_i M_i, sum w_i M_i / m_i and sum w_i m_i per channel, 17 significant digits. A Gaussian whose mass is
// 0 (none of the point's component lies in its reach) adds nothing to the normalised sum. `values` of one
// layer per level; Error (run) where a result is not finite.
std::string fit_truth_csv(std::span<const GaussianLevel> levels, const TruthValues& values);

}  // namespace truescatter
