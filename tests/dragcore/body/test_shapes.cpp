#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("flat-sided shapes have the area and volume of their formulas", "[shapes][analytic]") {
  for (const Shape& shape :
       {Shape(Plate{1.3, 0.7, 0.05}), Shape(Box{2.0, 1.0, 0.6}), Shape(Plate{1.0, 2.0, 0.0}), Shape(Prism{1.0, 0.7, 0.4})})
    for (const int divisions : {1, 2, 7}) {
      const MeshProperties found = inspect(triangulate(shape, divisions));
      const ShapeProperties exact = properties(shape);
      CHECK_THAT(found.area, WithinRel(exact.area, 1e-13));  // sums of some 200 rounded products
      CHECK_THAT(found.volume, WithinAbs(exact.volume, 1e-13));
    }
}

TEST_CASE("area and volume of round shapes converge with second order", "[shapes][convergence]") {
  for (const Shape& shape :
       {Shape(Sphere{1.0}), Shape(Cone{1.0, 0.7}), Shape(Cylinder{0.8, 1.5}), Shape(Ellipsoid{0.8, 0.5, 0.3}), Shape(Teardrop{1.0, 3.0})}) {
    const ShapeProperties exact = properties(shape);
    double area_error[2], volume_error[2];
    for (int level = 0; level < 2; ++level) {
      const MeshProperties found = inspect(triangulate(shape, 16 << level));
      area_error[level] = exact.area - found.area;
      volume_error[level] = exact.volume - found.volume;
    }
    INFO(kind(shape));
    // Chords cut the corner: the error is positive and falls by 4; 0.15 allows for the next term of the expansion, of relative size 1/16^2.
    CHECK(area_error[1] > 0.0);
    CHECK_THAT(std::log2(area_error[0] / area_error[1]), WithinAbs(2.0, 0.15));
    CHECK_THAT(std::log2(volume_error[0] / volume_error[1]), WithinAbs(2.0, 0.15));
    CHECK(area_error[1] < 5e-3 * exact.area);
  }
}

TEST_CASE("every triangulation is closed, wound outwards and centred on the centroid", "[shapes][invariance]") {
  for (const Shape& shape : zoo::shapes())
    for (const int divisions : {1, 2, 5, 12}) {
      INFO(kind(shape) << ", " << divisions << " divisions");
      const MeshProperties found = inspect(triangulate(shape, divisions));
      const bool sheet = zoo::sides_of(shape) == Surface::Sides::two;
      CHECK(found.closed == !sheet);
      CHECK(found.consistently_wound);
      CHECK_FALSE(found.inside_out);
      CHECK(found.degenerate == 0);
      CHECK(found.duplicated == 0);
      CHECK_THAT(found.centroid.y(), WithinAbs(0.0, 1e-13));  // rounding of sums over some 1000 triangles
      CHECK_THAT(found.centroid.z(), WithinAbs(0.0, 1e-13));
      // Facets move the centroid of a body that differs fore and aft, by their second-order error.
      CHECK_THAT(found.centroid.x(), WithinAbs(0.0, kind(shape) == "teardrop" ? 0.2 / (divisions * divisions) : 1e-13));
    }
}

TEST_CASE("closed forms agree with values worked out by hand", "[shapes][analytic]") {
  using std::numbers::pi;
  const ShapeProperties cone = properties(Cone{1.0, pi / 3});
  CHECK_THAT(cone.length_x, WithinRel(std::sqrt(3.0) / 2, 1e-14));
  CHECK_THAT(cone.area, WithinRel(pi * 0.5 * (0.5 + 1.0), 1e-14));
  CHECK_THAT(cone.volume, WithinRel(pi * 0.25 * std::sqrt(3.0) / 6, 1e-14));
  // Spheroids have elementary formulas: prolate 2 pi b^2 (1 + a/(b e) asin e), oblate 2 pi a^2 (1 + (1 - e^2)/e atanh e).
  const double e = std::sqrt(1.0 - 0.25);
  CHECK_THAT(properties(Ellipsoid{1.0, 0.5, 0.5}).area, WithinRel(2 * pi * 0.25 * (1 + 2.0 / e * std::asin(e)), 1e-12));
  CHECK_THAT(properties(Ellipsoid{0.5, 1.0, 1.0}).area, WithinRel(2 * pi * (1 + (1 - e * e) / e * std::atanh(e)), 1e-12));
  // Near a sphere: the mean of the products of two semi-axes is exact to second order in their differences, here 1e-6.
  CHECK_THAT(properties(Ellipsoid{1.0, 1.0, 1.0 - 1e-6}).area, WithinRel(4 * pi * (1 + 2 * (1 - 1e-6)) / 3, 1e-12));
  // Of three different semi-axes, flat and thin ones among them: Legendre's formula in 40 digits (mpmath 1.3). The rule keeps 1e-12.
  CHECK_THAT(properties(Ellipsoid{0.8, 0.5, 0.3}).area, WithinRel(3.4582070672949731, 1e-12));
  CHECK_THAT(properties(Ellipsoid{1.0, 2.0, 3.0}).area, WithinRel(48.882146302582060, 1e-12));
  CHECK_THAT(properties(Ellipsoid{0.01, 1.0, 1e-4}).area, WithinRel(0.062849107472883294, 1e-12));
  CHECK_THAT(properties(Ellipsoid{1.0, 0.7, 1e-6}).area, WithinRel(4.3982297151212311, 1e-12));
  CHECK_THAT(properties(Ellipsoid{0.5e-6, 1e-6, 1.0}).area, WithinRel(7.6092894385911148e-6, 1e-12));
  const ShapeProperties prism = properties(Prism{2.0, 3.0, pi / 3});  // equilateral
  CHECK_THAT(prism.area, WithinRel(3 * 2.0 * 3.0 + 2 * std::sqrt(3.0), 1e-14));
  CHECK_THAT(prism.volume, WithinRel(std::sqrt(3.0) * 3.0, 1e-14));
  CHECK_THAT(prism.nose_x, WithinRel(-2.0 / std::sqrt(3.0), 1e-14));  // radius of the circle through the corners
  // A teardrop that hardly has a tail is a sphere.
  CHECK_THAT(properties(Teardrop{1.0, 1.0 + 1e-9}).volume, WithinRel(pi / 6, 1e-8));
}

TEST_CASE("mirror symmetry is recognised in every direction", "[shapes][invariance]") {
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), diagonal(1, 1, 0), tilted(1, 0.3, 0);
  const Shape cube = Box{1, 1, 1}, box = Box{2, 1, 1}, cone = Cone{}, plate = Plate{};
  CHECK(mirror_symmetric(cube, x));
  CHECK(mirror_symmetric(cube, diagonal));
  CHECK_FALSE(mirror_symmetric(cube, tilted));
  CHECK(mirror_symmetric(box, Eigen::Vector3d(0, 1, -1)));
  CHECK_FALSE(mirror_symmetric(box, diagonal));
  CHECK_FALSE(mirror_symmetric(cone, x));
  CHECK(mirror_symmetric(cone, Eigen::Vector3d(0, 0.3, 0.7)));
  CHECK(mirror_symmetric(plate, z));
  CHECK(mirror_symmetric(plate, diagonal));
  CHECK_FALSE(mirror_symmetric(plate, Eigen::Vector3d(0, 1, 1)));
  const Shape prism = Prism{}, wedge = Prism{.apex_angle = 0.5};
  const Eigen::Vector3d other_median(std::sqrt(3.0), 0, 1);
  for (const Shape& either : {prism, wedge}) {
    CHECK(mirror_symmetric(either, y));
    CHECK(mirror_symmetric(either, z));
    CHECK_FALSE(mirror_symmetric(either, x));
    CHECK_FALSE(mirror_symmetric(either, diagonal));
  }
  CHECK(mirror_symmetric(prism, other_median));
  CHECK_FALSE(mirror_symmetric(wedge, other_median));
  CHECK_FALSE(mirror_symmetric(prism, Eigen::Vector3d(1, 0, std::sqrt(3.0))));
  CHECK(mirror_symmetric(Sphere{}, tilted));
  CHECK(mirror_symmetric(Ellipsoid{0.5, 0.5, 0.2}, tilted));
  CHECK_FALSE(mirror_symmetric(Ellipsoid{0.6, 0.5, 0.2}, tilted));
  CHECK_THROWS_WITH(mirror_symmetric(cube, Eigen::Vector3d::Zero()), Catch::Contains("normal"));
  // 45 degrees that went through a rotation matrix.
  const Pose pose{.yaw = std::numbers::pi / 4};
  CHECK(mirror_symmetric(cube, pose.rotation().transpose() * y));
}

TEST_CASE("a positive incidence lifts the nose and a positive yaw turns it to port", "[pose][sign]") {
  const Eigen::Vector3d nose(-1, 0, 0);
  CHECK((Pose{.incidence = 0.1}.rotation() * nose).z() > 0.0);
  CHECK((Pose{.yaw = 0.1}.rotation() * nose).y() < 0.0);
  CHECK((Pose{.incidence = 0.3, .yaw = 0.2, .roll = 0.1}.rotation().determinant()) == Approx(1.0));
}

TEST_CASE("shapes survive the way through their names and parameters", "[shapes]") {
  for (const Shape& shape : zoo::shapes()) {
    const Shape back = make_shape(kind(shape), parameters(shape));
    CHECK(kind(back) == kind(shape));
    CHECK_THAT(properties(back).volume, WithinRel(properties(shape).volume, 1e-14));
    CHECK(back.index() == shape.index());
  }
  CHECK(kind(make_shape("cube", {{"side", 2.0}})) == "cube");
}

TEST_CASE("a wrong parameter is named with its value and its range", "[shapes][hard]") {
  CHECK_THROWS_WITH(make_shape("cone", {{"apex_angle_deg", 180.0}}), Catch::Contains("apex_angle") && Catch::Contains("between 0 and pi"));
  CHECK_THROWS_WITH(make_shape("cone", {{"apex", 10.0}}),
                    Catch::Contains("unknown parameter 'apex'") && Catch::Contains("diameter, apex_angle_deg"));
  CHECK_THROWS_WITH(make_shape("kone", {}), Catch::Contains("unknown shape 'kone': did you mean cone?") && Catch::Contains("prism"));
  CHECK_THROWS_WITH(properties(Plate{.chord = -1.0}), Catch::Contains("chord = -1"));
  CHECK_THROWS_WITH(properties(Sphere{std::nan("")}), Catch::Contains("diameter"));
  CHECK_THROWS_WITH(properties(Teardrop{1.0, 0.9}), Catch::Contains("greater than its diameter"));
  CHECK_THROWS_WITH(triangulate(Sphere{}, 0), Catch::Contains("divisions = 0"));
}

TEST_CASE("a body given by triangles is moved to its centroid and measured", "[shapes][invariance]") {
  const TriangleMesh cube = triangulate(Box{}, 2);
  const MeshBody body = mesh_body("block", transformed(cube, Eigen::Matrix3d::Identity(), {3.0, -2.0, 5.0}), 0.5, 2.0);
  const ShapeProperties p = properties(body);
  CHECK(p.area == Approx(6.0));
  CHECK(p.volume == Approx(1.0));
  CHECK(p.reference_area == 0.5);
  CHECK(p.reference_length == 2.0);
  CHECK(p.nose_x == Approx(-0.5));
  CHECK(p.length_x == Approx(1.0));
  CHECK(p.half_extent.isApprox(Eigen::Vector3d::Constant(0.5)));
  CHECK(inspect(*body.mesh).centroid.norm() < 1e-12);  // rounding of coordinates up to 5
  CHECK(kind(body) == "block");
  CHECK(changed_parameters(body).empty());
  CHECK(triangulate(body, 7).triangles == body.mesh->triangles);  // divisions do not matter
  // Read again it is the same to the bit: results are found by its checksum.
  CHECK(mesh_body("block", *body.mesh, 0.5, 2.0).checksum == body.checksum);

  TriangleMesh open = cube;
  std::erase_if(open.triangles, [&](const auto& t) {
    return (cube.vertices[static_cast<std::size_t>(t[0])] + cube.vertices[static_cast<std::size_t>(t[1])] +
            cube.vertices[static_cast<std::size_t>(t[2])])
               .x() > 1.4;
  });
  const ShapeProperties shell = properties(mesh_body("open_block", open, 1.0, 1.0));
  CHECK(shell.area == Approx(5.0));
  CHECK(shell.volume == 0.0);
}

TEST_CASE("triangles are mirror symmetric where each is the image of another", "[shapes][invariance]") {
  // The diagonals of the 2 x 2 squares of a side are not mirrored; a tetrahedron over the axes is, about three of its planes.
  const MeshBody corner =
      mesh_body("corner", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}}, 1.0, 1.0);
  CHECK(mirror_symmetric(corner, {1, -1, 0}));
  CHECK(mirror_symmetric(corner, {0, 1, -1}));
  CHECK_FALSE(mirror_symmetric(corner, {1, 0, 0}));
  CHECK_FALSE(mirror_symmetric(corner, {1, 1, 0}));
}

TEST_CASE("a mesh that is no body is refused, and the message says why", "[shapes][hard]") {
  const TriangleMesh cube = triangulate(Box{}, 4);
  const auto fault = [](const std::string& name, const TriangleMesh& mesh, double area = 1.0) {
    try {
      mesh_body(name, mesh, area, 1.0);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(fault("fine", cube).empty());
  CHECK_THAT(fault("cone", cube), Contains("name of a shape"));
  CHECK_THAT(fault("My Body", cube), Contains("lower-case"));
  CHECK_THAT(fault("block", cube, 0.0), Contains("reference_area = 0"));
  TriangleMesh hole = cube;
  hole.triangles.pop_back();
  CHECK_THAT(fault("block", hole), Contains("3 edges are open") && Contains("hollow"));
  TriangleMesh turned = cube;
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  CHECK_THAT(fault("block", turned), Contains("opposite winding"));
  TriangleMesh inwards = cube;
  for (auto& t : inwards.triangles) std::swap(t[0], t[1]);
  CHECK_THAT(fault("block", inwards), Contains("wound inwards"));
  TriangleMesh twice = cube;
  twice.triangles.push_back(cube.triangles[0]);
  CHECK_THAT(fault("block", twice), Contains("three or more"));
}
