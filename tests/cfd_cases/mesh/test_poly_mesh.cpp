#include <catch2/catch.hpp>
#include <cmath>

#include "cfd_cases/flow_case/solve.hpp"
#include "cfd_cases/mesh/poly_mesh.hpp"
#include "tests/cfd_cases/temporary_folder.hpp"

using namespace cfd_cases;
using Catch::Matchers::Contains;
using Eigen::Vector3d;

namespace {

/// One cell of air, the unit cube, whose face at x = 1 is the body. A pressure of 2 and a shear of 3 up the wall act on it.
struct OneCell : TemporaryFolder {
  OneCell() {
    write("constant/polyMesh/points", "FoamFile { format ascii; }\n8\n((0 0 0)(1 0 0)(1 1 0)(0 1 0)\n(0 0 1) (1 0 1) (1 1 1) (0 1 1))\n");
    write("constant/polyMesh/faces",
          "FoamFile { format ascii; }\n6\n(\n4(1 2 6 5)\n4(0 4 7 3)\n4(0 1 5 4)\n4(3 7 6 2)\n4\n(\n0\n3\n2\n1\n)\n4(4 5 6 7)\n)\n");
    write("constant/polyMesh/owner", "FoamFile { format ascii; note \"nCells:1\"; }\n6(0 0 0 0 0 0)\n");
    write("constant/polyMesh/neighbour", "FoamFile { format ascii; }\n// none\n0()\n");
    write("constant/polyMesh/boundary",
          "FoamFile { format ascii; }\n2\n(\n    body { type wall; inGroups 1(wall); nFaces 1; startFace 0; }\n    rest { type patch; "
          "nFaces 5; startFace 1; }\n)\n");
    write("7/p", "FoamFile { format ascii; }\ninternalField   uniform 2;\nboundaryField { }\n");
    write_shear("uniform (0 0 -3)");
  }
  /// OpenFOAM's sign: the stress of the wall on the air.
  void write_shear(const std::string& value) const {
    write("7/wallShearStress",
          "FoamFile { format ascii; }\ninternalField uniform (0 0 0);\nboundaryField\n{\n    rest\n    {\n        value           uniform "
          "(9 9 9);\n    }\n    body\n    {\n"
          "        type calculated;\n        value           " +
              value + ";\n    }\n}\n");
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
  CHECK_THROWS_WITH(read_surface(one.path, one.mesh(), {{2.01, 0, 0}, {0, 0, 3}, {}, {}}, 0.5),
                    Contains("pressure on the faces adds up to (2 0 0)"));
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

namespace {

/// A slice of the cell around the edge of a body that fills x > 0, z < 0, bounded in the (x, z) plane by a b c (walls) and d e f (air,
/// which cell 1 stands for): an L with a leg of this length along x and one of 0.3 down along z.
PolyMesh edge_cell(double leg) {
  PolyMesh mesh;
  const double x[] = {leg, 0.0, 0.0, -0.3, -0.3, leg}, z[] = {0.0, 0.0, -0.3, -0.3, 0.3, 0.3};
  for (const double y : {0.0, 1.0})
    for (int i = 0; i < 6; ++i) mesh.points.emplace_back(x[i], y, z[i]);
  mesh.faces = {{0, 5, 4, 3, 2, 1}, {6, 7, 8, 9, 10, 11}, {2, 3, 9, 8}, {3, 4, 10, 9},
                {4, 5, 11, 10},     {5, 0, 6, 11},        {0, 1, 7, 6}, {1, 2, 8, 7}};
  mesh.owner.assign(8, 0);
  mesh.neighbour.assign(6, 1);
  mesh.patches = {{"body", 6, 2}};
  return mesh;
}

/// Centroid of the polygon a to f, by the shoelace formula.
Eigen::Vector2d centroid(const PolyMesh& mesh) {
  double area = 0.0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < 6; ++i) {
    const Eigen::Vector2d p(mesh.points[i].x(), mesh.points[i].z()), q(mesh.points[(i + 1) % 6].x(), mesh.points[(i + 1) % 6].z());
    const double cross = p.x() * q.y() - p.y() * q.x();
    area += cross / 2.0;
    moment += cross * (p + q) / 6.0;
  }
  return moment / area;
}

}  // namespace

TEST_CASE("a cell wrapped unevenly around a sharp edge is lifted until its centroid faces both its walls",
          "[cfd_cases][surface][regression]") {
  // Such cells made checkMesh refuse every sharp-edged body: their distance to the wall was negative.
  PolyMesh mesh = edge_cell(1.0);
  CHECK(face_geometry(mesh, 6).area_vector.isApprox(Vector3d(0, 0, -1)));  // into the body
  CHECK(face_geometry(mesh, 7).area_vector.isApprox(Vector3d(0.3, 0, 0)));
  REQUIRE(centroid(mesh).x() > 0.2);  // behind the wall b c
  const auto before = mesh.points;
  CHECK(lift_edge_cells(mesh, "body") == 1);
  // The clearance is a twelfth of the face's size, sqrt(0.3) and 1; the end caps stay plane, so that the slice's centroid is the cell's.
  CHECK(centroid(mesh).x() < -0.99 * std::sqrt(0.3) / 12.0);
  CHECK(centroid(mesh).y() > 0.99 / 12.0);
  for (const std::size_t wall_point : {0u, 1u, 2u, 6u, 7u, 8u}) CHECK(mesh.points[wall_point] == before[wall_point]);
}

TEST_CASE("a cell wrapped evenly around an edge stays as it is", "[cfd_cases][surface][limit]") {
  PolyMesh mesh = edge_cell(0.3);
  const auto before = mesh.points;
  CHECK(lift_edge_cells(mesh, "body") == 0);
  CHECK(mesh.points == before);
}
