#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "cfd_cases/mesh/o_grid.hpp"
#include "tests/cfd_cases/temporary_folder.hpp"

using namespace cfd_cases;
using Catch::Matchers::Contains;
using Eigen::Vector3d;

namespace {

MeshRecipe coarse() {
  MeshRecipe recipe = o_grid_recipe();
  recipe.refinement = refinement_of("coarse");
  return recipe;
}

/// Volume of each cell, by its faces' pyramids from the origin, which need not be in it.
Eigen::VectorXd cell_volumes(const PolyMesh& mesh) {
  Eigen::VectorXd volumes = Eigen::VectorXd::Zero(mesh.cells());
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const FaceGeometry geometry = face_geometry(mesh, static_cast<int>(face));
    const double pyramid = geometry.centre.dot(geometry.area_vector) / 3.0;
    volumes[mesh.owner[face]] += pyramid;
    if (face < mesh.neighbour.size()) volumes[mesh.neighbour[face]] -= pyramid;
  }
  return volumes;
}

const std::map<std::string, dragcore::Shape> kSmooth{{"ball", dragcore::Sphere{}},
                                                     {"prolate", dragcore::Ellipsoid{1.25, 0.5, 0.5}},
                                                     {"oblate", dragcore::Ellipsoid{0.2, 0.5, 0.5}},
                                                     {"cylinder", dragcore::Cylinder{.diameter = 1.0, .length = 2.0}},
                                                     {"teardrop", dragcore::Teardrop{}}};

}  // namespace

TEST_CASE("an O-grid has the body's area and volume, cells that fill the air, and as many as foretold", "[cfd_cases][mesh][analytic]") {
  for (const auto& [name, shape] : kSmooth)
    for (const Symmetry symmetry : {Symmetry::none, Symmetry::plane_y, Symmetry::plane_z}) {
      CAPTURE(name, to_string(symmetry));
      const PolyMesh mesh = o_grid(shape, {}, coarse(), symmetry);
      const double part = symmetry == Symmetry::none ? 1.0 : 0.5;
      CHECK(mesh.cells() == o_grid_cells(shape, coarse(), symmetry));
      const auto exact = dragcore::properties(shape);
      const PatchExtent wall = patch_extent(mesh, "body");
      const double allowed = allowed_surface_error(shape, coarse());
      CHECK(wall.area == Approx(part * exact.area).epsilon(allowed));
      CHECK(wall.volume == Approx(part * exact.volume).epsilon(allowed));
      const Eigen::VectorXd volumes = cell_volumes(mesh);
      CHECK(volumes.minCoeff() > 0.0);
      // What the far field encloses is the body and the air around it. Twelve digits and 20,000 cells leave 1e-9.
      CHECK(std::abs(patch_extent(mesh, "farfield").volume) - wall.volume == Approx(volumes.sum()).epsilon(1e-9));
      // OpenFOAM's order: by owner, then by neighbour, and the owner is the lower one.
      for (std::size_t face = 0; face < mesh.neighbour.size(); ++face) {
        if (mesh.owner[face] >= mesh.neighbour[face]) FAIL("face " << face << " points to a lower cell");
        if (face > 0 && std::pair(mesh.owner[face - 1], mesh.neighbour[face - 1]) >= std::pair(mesh.owner[face], mesh.neighbour[face]))
          FAIL("face " << face << " is out of order");
      }
    }
}

TEST_CASE("layers begin with the first, grow by the recipe and end at the far field", "[cfd_cases][mesh]") {
  const MeshRecipe recipe = o_grid_recipe();
  const auto bounds = o_grid_layers(recipe, 2.0);
  CHECK(bounds.front() == 0.0);
  CHECK(bounds.back() == Approx(2.0 * recipe.far_radius).epsilon(1e-12));
  // All are stretched so that the last ends at the far field, by less than the growth of one of them.
  CHECK(bounds[1] <= 2.0 * recipe.first_layer);
  CHECK(bounds[1] > 2.0 * recipe.first_layer / (1.0 + recipe.growth));
  for (std::size_t i = 2; i < bounds.size(); ++i)
    CHECK((bounds[i] - bounds[i - 1]) / (bounds[i - 1] - bounds[i - 2]) <= 1.0 + recipe.growth + 1e-9);
}

TEST_CASE("the body turns in an O-grid and the air does not: the far field stays further behind than before", "[cfd_cases][mesh]") {
  const dragcore::Shape shape = dragcore::Ellipsoid{1.25, 0.5, 0.5};
  const PolyMesh mesh = o_grid(shape, {.incidence = 0.5 * std::numbers::pi}, coarse(), Symmetry::plane_y);
  Vector3d lower = Vector3d::Zero(), upper = Vector3d::Zero();
  for (const Vector3d& p : mesh.points) lower = lower.cwiseMin(p), upper = upper.cwiseMax(p);
  CHECK(lower.y() == Approx(0.0).margin(1e-12));
  CHECK(lower.x() == Approx(-8.0).margin(1.2));  // upstream, beyond half the thickness, less what the drift gains near the body
  CHECK(upper.x() == Approx(20.0).margin(1.2));
  const auto& wall = mesh.patch("body");
  double length = 0.0;
  for (int i = 0; i < wall.faces; ++i) length = std::max(length, face_geometry(mesh, wall.first_face + i).centre.z());
  CHECK(length == Approx(1.25).epsilon(0.02));  // the nose is up; faces lie inside of it
}

TEST_CASE("an O-grid refuses bodies with flat sides and halves that cut through its cells", "[cfd_cases][mesh][hard]") {
  CHECK_THROWS_WITH(o_grid_cells(dragcore::Box{}, coarse(), Symmetry::none), Contains("not a box") || Contains("not a cube"));
  CHECK_THROWS_WITH(o_grid(dragcore::Sphere{}, {.roll = 0.3}, coarse(), Symmetry::plane_y), Contains("roll_deg"));
}

TEST_CASE("a mesh that is written is read back the same", "[cfd_cases][mesh]") {
  const TemporaryFolder folder;
  const PolyMesh mesh = o_grid(dragcore::Sphere{}, {}, coarse(), Symmetry::plane_y);
  write_poly_mesh(folder.path / "constant/polyMesh", mesh);
  const PolyMesh back = read_poly_mesh(folder.path / "constant/polyMesh");
  CHECK(back.faces == mesh.faces);
  CHECK(back.owner == mesh.owner);
  CHECK(back.neighbour == mesh.neighbour);
  REQUIRE(back.patches.size() == 3);
  CHECK(back.patch("symmetry").first_face == mesh.patch("symmetry").first_face);
  double worst = 0.0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) worst = std::max(worst, (back.points[i] - mesh.points[i]).norm());
  CHECK(worst < 1e-10);  // twelve digits of up to 20 m
}
