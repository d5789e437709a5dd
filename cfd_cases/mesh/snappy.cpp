#include "cfd_cases/mesh/snappy.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cfd_cases {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

namespace {

/// Cells between two levels of cubes: with one, the corners of a step touch.
constexpr int kBetweenLevels = 2;
/// Depth of the layer of smallest cubes around the body, in body scales: a little more than two of them. Without a layer, a body of the
/// size of a cube of the background is missed without a word.
constexpr double kLayer = 0.12;

struct Regions {
  double cube = 0.0;  ///< of the background [m]
  AlignedBox3d air, wake, outer;
  Eigen::Vector3i cubes;
  int body_level = 0, edge_level = 0, wake_level = 0, outer_level = 0;
  double layer = 0.0;  ///< [m]

  double size(int level) const { return std::ldexp(cube, -level); }
};

dragcore::TriangleMesh turned(const dragcore::MeshBody& body, const dragcore::Pose& pose) {
  return dragcore::transformed(*body.mesh, pose.rotation(), Vector3d::Zero());
}

bool is_shell(const dragcore::MeshBody& body) { return body.measured.volume == 0.0; }

Regions regions_of(const dragcore::MeshBody& body, const dragcore::Pose& pose, const MeshRecipe& recipe, Symmetry symmetry) {
  AlignedBox3d box;
  for (const Vector3d& vertex : turned(body, pose).vertices) box.extend(vertex);
  const double scale = body_scale(body);
  const auto around = [&](double margin, double length) {
    return AlignedBox3d(box.min() - Vector3d::Constant(scale * margin), box.max() + scale * Vector3d(length, margin, margin));
  };
  const auto level = [&](double size) { return std::max(0, static_cast<int>(std::lround(std::log2(recipe.far_size / size)))); };
  Regions regions{.cube = recipe.far_size * recipe.refinement * scale,
                  .air = air_around(box, scale, recipe, symmetry),
                  .wake = around(recipe.wake_margin, recipe.wake_length),
                  .outer = around(recipe.outer_margin, recipe.outer_length),
                  .cubes = {},
                  .body_level = level(recipe.body_size),
                  .edge_level = level(recipe.body_size) + is_shell(body),
                  .wake_level = level(recipe.wake_size),
                  .outer_level = level(recipe.outer_size),
                  .layer = kLayer * recipe.refinement * scale};
  // Whole cubes: the air grows by what is missing, equally to both sides, but for a plane of symmetry.
  for (int axis = 0; axis < 3; ++axis) regions.cubes[axis] = static_cast<int>(std::ceil(regions.air.sizes()[axis] / regions.cube));
  const Vector3d missing = regions.cube * regions.cubes.cast<double>() - regions.air.sizes();
  Vector3d below = 0.5 * missing;
  if (halved_axis(symmetry) >= 0) below[halved_axis(symmetry)] = 0.0;
  regions.air = AlignedBox3d(regions.air.min() - below, regions.air.max() + missing - below);
  return regions;
}

std::string header(const std::string& name) {
  return fmt::format("FoamFile {{ version 2.0; format ascii; class dictionary; object {}; }}\n", name);
}

std::string point(const Vector3d& p) { return fmt::format("({:.12g} {:.12g} {:.12g})", p.x() + 0.0, p.y() + 0.0, p.z() + 0.0); }

std::string stl(const dragcore::TriangleMesh& mesh) {
  std::string text = "solid body\n";
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int corner : triangle) {
      const Vector3d& p = mesh.vertices[static_cast<std::size_t>(corner)];
      text += fmt::format("vertex {:.12g} {:.12g} {:.12g}\n", p.x() + 0.0, p.y() + 0.0, p.z() + 0.0);
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid body\n";
}

std::string background(const Regions& regions, Symmetry symmetry) {
  const std::string lower_y = "(0 1 5 4)", lower_z = "(0 3 2 1)";
  const std::string plane = symmetry == Symmetry::plane_y ? lower_y : symmetry == Symmetry::plane_z ? lower_z : "";
  std::string sides = "(3 7 6 2) (4 5 6 7)";
  for (const std::string& side : {lower_y, lower_z})
    if (side != plane) sides += " " + side;
  std::string corners;
  for (const auto& [x, y, z] : {std::tuple{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}})
    corners += point(regions.air.min() + regions.air.sizes().cwiseProduct(Vector3d(x, y, z))) + " ";
  return header("blockMeshDict") + fmt::format(R"foam(
scale 1;
vertices ( {} );
blocks ( hex (0 1 2 3 4 5 6 7) ({} {} {}) simpleGrading (1 1 1) );
boundary
(
  inlet {{ type patch; faces ( (0 4 7 3) ); }}
  outlet {{ type patch; faces ( (1 2 6 5) ); }}
  sides {{ type patch; faces ( {} ); }}
{});
)foam",
                                               corners, regions.cubes.x(), regions.cubes.y(), regions.cubes.z(), sides,
                                               plane.empty() ? "" : "  symmetry { type symmetry; faces ( " + plane + " ); }\n");
}

/// Points of the wall are drawn to the nearest place as they are: smoothed before, three times as usual, they creep in from the rim of a
/// shell, which then lacks 1 to 2 % of its area instead of 0.3 %.
std::string refinement(const Regions& regions) {
  const auto box = [](const AlignedBox3d& of) {
    return fmt::format("type searchableBox; min {}; max {};", point(of.min()), point(of.max()));
  };
  // A point of the air far upstream, inside a cube and on none of its halves.
  const Vector3d outside = regions.air.min() + regions.cube * Vector3d(0.37, 0.41, 0.43);
  return header("snappyHexMeshDict") + fmt::format(R"foam(
castellatedMesh true;  snap true;  addLayers false;
geometry
{{
  body.stl {{ type triSurfaceMesh; name body; }}
  wake {{ {0} }}
  outer {{ {1} }}
}}
castellatedMeshControls
{{
  maxLocalCells 5000000;  maxGlobalCells 5000000;  minRefinementCells 0;  maxLoadUnbalance 0.1;
  nCellsBetweenLevels {2};
  features ( {{ file "body.eMesh"; level {8}; }} );
  refinementSurfaces {{ body {{ level ({3} {8}); patchInfo {{ type wall; }} }} }}
  resolveFeatureAngle 30;
  refinementRegions
  {{
    body {{ mode distance; levels (({4:.12g} {3})); }}
    wake {{ mode inside; levels ((1e15 {5})); }}
    outer {{ mode inside; levels ((1e15 {6})); }}
  }}
  locationInMesh {7};
  allowFreeStandingZoneFaces true;
}}
snapControls
{{
  nSmoothPatch 0;  tolerance 2;  nSolveIter 50;  nRelaxIter 5;  nFeatureSnapIter 10;
  implicitFeatureSnap false;  explicitFeatureSnap true;  multiRegionFeatureSnap false;
}}
addLayersControls
{{
  relativeSizes true;  layers {{}}  expansionRatio 1;  finalLayerThickness 0.3;  minThickness 0.1;  nGrow 0;  featureAngle 60;
  nRelaxIter 3;  nSmoothSurfaceNormals 1;  nSmoothNormals 3;  nSmoothThickness 10;  maxFaceThicknessRatio 0.5;
  maxThicknessToMedialRatio 0.3;  minMedianAxisAngle 90;  nBufferCellsNoExtrude 0;  nLayerIter 50;
}}
meshQualityControls
{{
  maxNonOrtho 65;  maxBoundarySkewness 20;  maxInternalSkewness 4;  maxConcave 80;  minVol 1e-13;  minTetQuality 1e-15;  minArea -1;
  minTwist 0.02;  minDeterminant 0.001;  minFaceWeight 0.05;  minVolRatio 0.01;  minTriangleTwist -1;
  nSmoothScale 4;  errorReduction 0.75;
}}
mergeTolerance 1e-6;
)foam",
                                                   box(regions.wake), box(regions.outer), kBetweenLevels, regions.body_level, regions.layer,
                                                   regions.wake_level, regions.outer_level, point(outside), regions.edge_level);
}

}  // namespace

std::map<std::string, std::string> snappy_files(const dragcore::MeshBody& body, const dragcore::Pose& pose, const MeshRecipe& recipe,
                                                Symmetry symmetry) {
  const Regions regions = regions_of(body, pose, recipe, symmetry);
  return {{"constant/triSurface/body.stl", stl(turned(body, pose))},
          {"system/blockMeshDict", background(regions, symmetry)},
          {"system/snappyHexMeshDict", refinement(regions)},
          {"system/surfaceFeatureExtractDict",
           header("surfaceFeatureExtractDict") +
               "body.stl { extractionMethod extractFromSurface; extractFromSurfaceCoeffs { includedAngle 150; }\n"
               "  subsetFeatures { nonManifoldEdges yes; openEdges yes; } writeObj no; }\n"}};
}

double snappy_cells(const dragcore::MeshBody& body, const dragcore::Pose& pose, const MeshRecipe& recipe, Symmetry symmetry) {
  const Regions regions = regions_of(body, pose, recipe, symmetry);
  const double share = symmetry == Symmetry::none ? 1.0 : 0.5;
  // Each region, grown by the cubes between two levels, in cubes of its own size less what they replace.
  const auto gained = [&](double volume, int level, int below) {
    return volume * (std::pow(regions.size(level), -3) - std::pow(regions.size(below), -3));
  };
  const auto grown = [&](const AlignedBox3d& box, int level) {
    return share * (box.sizes() + Vector3d::Constant(0.75 * kBetweenLevels * regions.size(level - 1))).prod();
  };
  double cells = regions.cubes.cast<double>().prod();
  cells += gained(grown(regions.outer, regions.outer_level), regions.outer_level, 0);
  cells += gained(grown(regions.wake, regions.wake_level), regions.wake_level, regions.outer_level);
  const double area = share * (is_shell(body) ? 2.0 : 1.0) * body.measured.area;
  const double depth = regions.layer + 0.5 * regions.size(regions.body_level);
  cells += gained(area * depth, regions.body_level, regions.wake_level);
  return cells - share * body.measured.volume / std::pow(regions.size(regions.wake_level), 3);
}

std::string snappy_fault(const dragcore::MeshBody& body, const MeshRecipe& recipe, Symmetry symmetry, const PolyMesh& mesh) {
  for (const char* name : {"inlet", "outlet", "sides", "body"}) {
    const auto patch = std::find_if(mesh.patches.begin(), mesh.patches.end(), [&](const auto& one) { return one.name == name; });
    if (patch == mesh.patches.end() || patch->faces == 0)
      return fmt::format("the patch {} has no faces: {}", name,
                         std::string(name) == "body" ? "the body was missed" : "the inside of the body was meshed");
  }
  const bool shell = is_shell(body);
  PatchExtent extent = patch_extent(mesh, "body");
  if (symmetry != Symmetry::none) extent = {2.0 * extent.area, 2.0 * extent.volume};
  const double area = (shell ? 2.0 : 1.0) * body.measured.area;
  const double allowed = std::max(0.01, allowed_surface_error(body, recipe));
  // Edges that cross the cubes at an angle are snapped with ridges, which add area, and no volume, with the size of the cells: 2.4 % on an
  // L-bracket in an oblique pose on medium cells, 3.5 % on coarse ones, 1.4 times as large.
  const double most = std::max(allowed, 0.03 * recipe.refinement), excess = extent.area / area - 1.0;
  if (!(excess >= -allowed && excess <= most))
    return fmt::format("the wall has {:.6g} m2, but the {} {} has {:.6g} m2 (allowed error -{:.2g} to {:.2g})", extent.area,
                       shell ? "two sides of the shell" : "closed body", body.name, area, allowed, most);
  // A shell has none of its own: a layer of a hundredth of the body's scale on its area is what a closed opening would exceed by far.
  const double volume_scale = shell ? body.measured.area * body_scale(body) : body.measured.volume;
  if (!(std::abs(extent.volume - body.measured.volume) <= allowed * volume_scale))
    return fmt::format("the wall encloses {:.6g} m3, but the {} {} has {:.6g} m3 (allowed error {:.2g} of {:.6g} m3)", extent.volume,
                       shell ? "open shell" : "closed body", body.name, body.measured.volume, allowed, volume_scale);
  Vector3d sum = Vector3d::Zero();
  const auto& patch = mesh.patch("body");
  for (int i = 0; i < patch.faces; ++i) sum += face_geometry(mesh, patch.first_face + i).area_vector;
  if (halved_axis(symmetry) >= 0) sum[halved_axis(symmetry)] = 0.0;
  // Points are written with 12 digits.
  if (!(sum.norm() <= 1e-8 * area))
    return fmt::format("the faces of the wall do not close: their area vectors add up to {:.3g} m2", sum.norm());
  return {};
}

}  // namespace cfd_cases
