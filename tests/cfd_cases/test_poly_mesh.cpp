#include <catch2/catch.hpp>

#include "cfd_cases/poly_mesh.hpp"
#include "cfd_cases/solve.hpp"
#include "temporary_folder.hpp"

using namespace cfd_cases;
using Catch::Matchers::Contains;
using Eigen::Vector3d;

namespace {

/// One cell of air, the unit cube, whose face at x = 1 is the body. A pressure of 2 and a shear of 3 up the wall act on it.
struct OneCell : TemporaryFolder {
  OneCell() {
    write("constant/polyMesh/points", "FoamFile { format ascii; }\n8\n((0 0 0)(1 0 0)(1 1 0)(0 1 0)\n(0 0 1) (1 0 1) (1 1 1) (0 1 1))\n");
    write("constant/polyMesh/faces", "FoamFile { format ascii; }\n6\n(\n4(1 2 6 5)\n4(0 4 7 3)\n4(0 1 5 4)\n4(3 7 6 2)\n4\n(\n0\n3\n2\n1\n)\n4(4 5 6 7)\n)\n");
    write("constant/polyMesh/owner", "FoamFile { format ascii; note \"nCells:1\"; }\n6(0 0 0 0 0 0)\n");
    write("constant/polyMesh/neighbour", "FoamFile { format ascii; }\n// none\n0()\n");
    write("constant/polyMesh/boundary",
          "FoamFile { format ascii; }\n2\n(\n    body { type wall; inGroups 1(wall); nFaces 1; startFace 0; }\n    rest { type patch; nFaces 5; startFace 1; }\n)\n");
    write("7/p", "FoamFile { format ascii; }\ninternalField   uniform 2;\nboundaryField { }\n");
    write_shear("uniform (0 0 -3)");
  }
  /// OpenFOAM's sign: the stress of the wall on the air.
  void write_shear(const std::string& value) const {
    write("7/wallShearStress", "FoamFile { format ascii; }\ninternalField uniform (0 0 0);\nboundaryField\n{\n    rest\n    {\n        value           uniform (9 9 9);\n    }\n    body\n    {\n"
                               "        type calculated;\n        value           " + value + ";\n    }\n}\n");
  }
  PolyMesh mesh() const { return read_poly_mesh(path / "constant/polyMesh"); }
};

const case_record::Load kLoad{{2, 0, 0}, {0, 0, 3}, {}, {}};

}  // namespace

TEST_CASE("pressure pushes the body away from the air and shear drags it along", "[cfd_cases][surface][sign]") {
  const OneCell one;
  const auto sample = read_surface(one.path, one.mesh(), kLoad, 0.5);
  REQUIRE(sample.centre.cols() == 1);
  CHECK(sample.centre.col(0).isApprox(Vector3d(1.0, 0.5, 0.5)));
  CHECK(sample.area_vector.col(0).isApprox(Vector3d(-1.0, 0.0, 0.0)));  // out of the body, into the air
  CHECK(sample.pressure_coefficient[0] == Approx(4.0));
  CHECK(sample.friction_coefficient.col(0).isApprox(Vector3d(0.0, 0.0, 6.0)));
}

TEST_CASE("a surface that does not add up to the solver's forces is refused", "[cfd_cases][surface][hard]") {
  const OneCell one;
  CHECK_THROWS_WITH(read_surface(one.path, one.mesh(), {{2.01, 0, 0}, {0, 0, 3}, {}, {}}, 0.5), Contains("pressure on the faces adds up to (2 0 0)"));
  CHECK_THROWS_WITH(read_surface(one.path, one.mesh(), {{2, 0, 0}, {0, 0, -3}, {}, {}}, 0.5), Contains("shear stress"));
}

TEST_CASE("fields that are incomplete or not finite are refused", "[cfd_cases][surface][hard]") {
  const OneCell one;
  one.write_shear("nonuniform List<vector> 1((0 0 -3))");
  CHECK_NOTHROW(read_surface(one.path, one.mesh(), kLoad, 0.5));
  one.write_shear("nonuniform List<vector> 2((0 0 -3)(0 0 1))");
  CHECK_THROWS_WITH(read_surface(one.path, one.mesh(), kLoad, 0.5), Contains("2 values, needed 1"));
  one.write_shear("nonuniform List<vector> 1((0 0");
  CHECK_THROWS_WITH(read_surface(one.path, one.mesh(), kLoad, 0.5), Contains("truncated"));
  one.write_shear("uniform (0 0 nan)");
  CHECK_THROWS_WITH(read_surface(one.path, one.mesh(), kLoad, 0.5), Contains("not finite"));
  std::filesystem::remove_all(one.path / "7");
  CHECK_THROWS_WITH(read_surface(one.path, one.mesh(), kLoad, 0.5), Contains("no time folder"));
}

TEST_CASE("a mesh that is truncated or binary is refused", "[cfd_cases][surface][hard]") {
  const OneCell one;
  CHECK(one.mesh().cells() == 1);
  CHECK_THROWS_WITH(one.mesh().patch("wing"), Contains("no patch 'wing'") && Contains("body rest"));
  one.write("constant/polyMesh/owner", "FoamFile { format ascii; }\n5(0 0 0 0 0)\n");
  CHECK_THROWS_WITH(one.mesh(), Contains("owner has 5"));
  one.write("constant/polyMesh/points", "FoamFile { format ascii; }\n8\n((0 0 0)(1 0 0)\n");
  CHECK_THROWS_WITH(one.mesh(), Contains("points") && Contains("truncated"));
  one.write("constant/polyMesh/points", "FoamFile { format binary; }\n8\n");
  CHECK_THROWS_WITH(one.mesh(), Contains("binary"));
}

TEST_CASE("the area of a patch and the volume under it are those of the solid", "[cfd_cases][surface][analytic]") {
  const OneCell one;
  const PatchExtent body = patch_extent(one.mesh(), "body"), rest = patch_extent(one.mesh(), "rest");
  CHECK(body.area == Approx(1.0));
  CHECK(rest.area == Approx(5.0));
  CHECK(body.volume + rest.volume == Approx(-1.0));  // seen from the air all round: minus the cell
}

TEST_CASE("a cell wrapped unevenly around a sharp edge is lifted until its centroid faces all its walls", "[cfd_cases][surface][regression]") {
  // The dual of a tetrahedral mesh around a body's edge, in one slice: an L with a long leg along x (2 x 0.3) and a short one down along z. Its
  // centroid lay behind the wall of the short leg, checkMesh refused the mesh. Corners a..f in the (x, z) plane, walls ab (facing +z) and bc
  // (facing... the corner b is the edge of the body, which fills x > 0, z < 0); c d e f a is open air.
  PolyMesh mesh;
  const double x[] = {2.0, 0.0, 0.0, -0.3, -0.3, 2.0}, z[] = {0.0, 0.0, -0.3, -0.3, 0.3, 0.3};
  for (const double y : {0.0, 1.0})
    for (int i = 0; i < 6; ++i) mesh.points.emplace_back(x[i], y, z[i]);
  // Cell 0 is the L, cell 1 a box beyond its upper side, so that the points 4, 5 (and 10, 11) have a face between cells.
  for (const double y : {0.0, 1.0}) {
    mesh.points.emplace_back(-0.3, y, 1.0);
    mesh.points.emplace_back(2.0, y, 1.0);
  }
  mesh.faces = {{4, 10, 11, 5},                                          // between the cells, out of the L: +z
                {0, 6, 7, 1}, {1, 7, 8, 2},                              // walls, into the body: -z and +x
                {0, 1, 2, 3, 4, 5}, {6, 11, 10, 9, 8, 7}, {2, 8, 9, 3}, {3, 9, 10, 4}, {5, 11, 6, 0}};
  mesh.owner.assign(mesh.faces.size(), 0);
  mesh.neighbour = {1};
  mesh.patches = {{"body", 1, 2}, {"rest", 3, 5}};
  CHECK(face_geometry(mesh, 1).area_vector.isApprox(Vector3d(0, 0, -2)));
  CHECK(face_geometry(mesh, 2).area_vector.isApprox(Vector3d(0.3, 0, 0)));
  // Every point of this slice is on a patch: nothing may move, and the walls least of all.
  const auto before = mesh.points;
  CHECK(lift_edge_cells(mesh, "body") == 1);
  CHECK(mesh.points == before);
}
