#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST_CASE("what is odd about a mesh is found and said", "[mesh][hard]") {
  TriangleMesh mesh = triangulate(Box{}, 1);
  SECTION("a hole") {
    mesh.triangles.pop_back();
    CHECK_FALSE(inspect(mesh).closed);
    CHECK(inspect(mesh).boundary_edges == 3);
  }
  SECTION("one triangle the wrong way round") {
    std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
    CHECK_FALSE(inspect(mesh).consistently_wound);
    CHECK(inspect(mesh).inconsistent_edges == 3);
    CHECK_THROWS_WITH(Surface(mesh, Surface::Sides::one), Catch::Contains("wound in opposite directions at 3 edges"));
    CHECK_NOTHROW(Surface(mesh, Surface::Sides::two));
  }
  SECTION("all of it inside out") {
    for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
    CHECK(inspect(mesh).inside_out);
    CHECK_THROWS_WITH(Surface(mesh, Surface::Sides::one), Catch::Contains("inside out"));
  }
  SECTION("a triangle twice") {
    mesh.triangles.push_back(mesh.triangles.front());
    CHECK(inspect(mesh).duplicated == 1);
    CHECK_FALSE(inspect(mesh).closed);
  }
  SECTION("a needle and a triangle of two points") {
    mesh.triangles.emplace_back(0, 0, 1);
    mesh.vertices.push_back(0.5 * (mesh.vertices[0] + mesh.vertices[1]));
    mesh.triangles.emplace_back(0, 1, static_cast<int>(mesh.vertices.size()) - 1);
    CHECK(inspect(mesh).degenerate == 2);
    CHECK(describe(inspect(mesh)).find("2 degenerate") != std::string::npos);
  }
  SECTION("a coordinate that is not a number") {
    mesh.vertices[5].y() = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_WITH(Surface(mesh), Catch::Contains("vertex 5") && Catch::Contains("finite"));
  }
  SECTION("an index out of range") {
    mesh.triangles[2][1] = 99;
    CHECK_THROWS_WITH(inspect(mesh), Catch::Contains("triangle 2") && Catch::Contains("vertex 99") && Catch::Contains("8 vertices"));
  }
}

TEST_CASE("a sheet feels the air on both sides and a body on its outer one, found from the mesh", "[mesh][limit]") {
  const auto sides = [](const TriangleMesh& mesh) { return Surface(mesh).sides; };
  const TriangleMesh sheet = triangulate(Plate{1.0, 1.0, 0.0}, 2), box = triangulate(Box{}, 4);
  CHECK(sides(sheet) == Surface::Sides::two);
  CHECK_THAT(inspect(sheet).hole_area, WithinRel(1.0, 1e-14));
  CHECK(sides(box) == Surface::Sides::one);
  CHECK(inspect(box).hole_area == 0.0);
  CHECK(sides(TriangleMesh{}) == Surface::Sides::one);
  // What matters: a sheet feels the wind whichever way it is wound.
  const Wrench front = wrench(Surface(sheet), {.wind = {0, 0, 1}}, {}, {}).total(),
               back = wrench(Surface(sheet), {.wind = {0, 0, -1}}, {}, {}).total();
  CHECK_THAT(front.force.z(), WithinRel(0.5 * 1.225, 1e-14));
  CHECK(back.force == -front.force);

  // Cracks and missing walls leave a body a body, of the same volume: lids close them.
  TriangleMesh cracked = box, lidless = box;
  cracked.triangles.erase(cracked.triangles.begin() + 40, cracked.triangles.begin() + 42);
  CHECK(inspect(cracked).encloses);
  CHECK_FALSE(inspect(cracked).closed);
  CHECK_THAT(inspect(cracked).hole_area, WithinRel(1.0 / 16.0, 1e-13));
  CHECK_THAT(Surface(cracked).volume, WithinRel(1.0, 1e-13));
  CHECK(sides(cracked) == Surface::Sides::one);
  CHECK(describe(inspect(cracked)).find("a body with holes of 0.0625 m^2") != std::string::npos);
  lidless.triangles.resize(lidless.triangles.size() - 32);
  CHECK_THAT(inspect(lidless).hole_area, WithinRel(1.0, 1e-13));
  CHECK(sides(lidless) == Surface::Sides::one);
  CHECK_THAT(Surface(lidless).volume, WithinRel(1.0, 1e-13));
  CHECK(describe(inspect(lidless)).find("an open sheet") != std::string::npos);
  CHECK(Surface(lidless, Surface::Sides::one).sides == Surface::Sides::one);
  CHECK_THAT(Surface(lidless, Surface::Sides::one).volume, WithinRel(1.0, 1e-13));  // told that it is a body, it is one
  CHECK(Surface(lidless, Surface::Sides::one).body_class == BodyClass::sharp);
  for (auto& t : cracked.triangles) std::swap(t[0], t[1]);
  CHECK_THROWS_WITH(Surface(cracked, Surface::Sides::one), Catch::Contains("inside out"));

  // Two cubes that touch in an edge, and a cube with a wall inside: bodies of volume 2 and 1.
  TriangleMesh two = triangulate(Box{}, 1);
  const TriangleMesh other = transformed(two, Matrix3d::Identity(), Vector3d(1, 1, 0));
  for (const auto& t : other.triangles) two.triangles.push_back(t + Eigen::Vector3i::Constant(static_cast<int>(two.vertices.size())));
  two.vertices.insert(two.vertices.end(), other.vertices.begin(), other.vertices.end());
  CHECK(inspect(two).non_manifold_edges == 1);
  CHECK(sides(two) == Surface::Sides::one);
  CHECK_THAT(Surface(two).volume, WithinRel(2.0, 1e-13));
  TriangleMesh walled = triangulate(Box{}, 2);
  const TriangleMesh wall = triangulate(Plate{1.0, 1.0, 0.0}, 2);
  for (const auto& t : wall.triangles) walled.triangles.push_back(t + Eigen::Vector3i::Constant(static_cast<int>(walled.vertices.size())));
  walled.vertices.insert(walled.vertices.end(), wall.vertices.begin(), wall.vertices.end());
  CHECK(inspect(walled).boundary_edges == 0);
  CHECK(sides(walled) == Surface::Sides::one);
  CHECK_THAT(Surface(walled).volume, WithinRel(1.0, 1e-13));
}

TEST_CASE("a needle of 1 : 1e6 is a triangle, not a fault", "[mesh][hard]") {
  CHECK_FALSE(is_degenerate(Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0.5, 1e-6, 0)));
  CHECK_FALSE(is_degenerate(1e-160 * Vector3d(0, 0, 0), 1e-160 * Vector3d(1, 0, 0), 1e-160 * Vector3d(0, 1, 0)));
  CHECK(is_degenerate(Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(2, 0, 0)));
}

TEST_CASE("an empty mesh is open, without area, and feels nothing", "[mesh][limit]") {
  const TriangleMesh empty;
  CHECK_FALSE(inspect(empty).closed);
  CHECK(describe(inspect(empty)) == "no triangles");
  const Wrench total = wrench(Surface(empty), {.wind = Vector3d(1, 2, 3)}, {}, {}).total();
  CHECK(total.force.isZero(0.0));
  CHECK(total.torque.isZero(0.0));
}

TEST_CASE("mirroring and uneven scale keep normals outward and areas right", "[mesh][invariance]") {
  const TriangleMesh box = triangulate(Box{1, 1, 1}, 3);
  const Matrix3d stretch = Vector3d(2.0, -1.0, 0.5).asDiagonal();
  const MeshProperties found = inspect(transformed(box, stretch, Vector3d(5, 6, 7)));
  CHECK_FALSE(found.inside_out);
  CHECK_THAT(found.volume, WithinRel(1.0, 1e-13));
  CHECK_THAT(found.area, WithinRel(2 * (2.0 + 1.0 + 0.5), 1e-13));
  CHECK((found.centroid - Vector3d(5, 6, 7)).norm() < 1e-13);
}

TEST_CASE("patches are the faces, whatever the triangulation", "[surface][invariance]") {
  for (const int divisions : {1, 2, 9}) {
    const Surface cube(triangulate(Box{1, 1, 1}, divisions));
    REQUIRE(cube.patches.size() == 6);
    for (const Patch& patch : cube.patches) {
      CHECK(patch.outline.size() == 4);
      CHECK_THAT(patch.area, WithinRel(1.0, 1e-13));
      CHECK_THAT(patch.second_moment.trace(), WithinRel(1.0 / 6.0, 1e-12));  // 1/12 in each of two directions
      CHECK((patch.second_moment * patch.normal).norm() < 1e-14);
    }
  }
  // A cone of 4 n sides: one patch a side, and its base.
  CHECK(Surface(triangulate(Cone{}, 4)).patches.size() == 17);
}

TEST_CASE("a patch with a hole keeps both outlines", "[surface]") {
  // A square frame: the outer square of side 3 without the inner one of side 1.
  const TriangleMesh full = triangulate(Plate{3.0, 3.0, 0.0}, 3);
  TriangleMesh frame{full.vertices, {}};
  for (const auto& t : full.triangles) {
    const Vector3d centre = (full.vertices[t[0]] + full.vertices[t[1]] + full.vertices[t[2]]) / 3.0;
    if (centre.cwiseAbs().maxCoeff() > 0.5) frame.triangles.push_back(t);
  }
  const Surface surface(frame, Surface::Sides::two);
  REQUIRE(surface.patches.size() == 1);
  CHECK(surface.patches[0].outline.size() == 8);
  CHECK_THAT(surface.patches[0].area, WithinRel(8.0, 1e-14));
}

TEST_CASE("welding and counting edges give what going through all pairs gives", "[mesh][property]") {
  // Corners on a coarse lattice meet often: vertices, triangles and edges of every multiplicity. 0 and -0 are one place.
  zoo::Random random(5);
  const auto below = [&](int n) { return std::min(n - 1, static_cast<int>(random.uniform(0.0, n))); };
  for (int round = 0; round < 300; ++round) {
    TriangleMesh mesh;
    for (int i = 3 + below(25); i > 0; --i) mesh.vertices.emplace_back(below(3) - 1, -0.3 * below(2), 1e-20 * below(2));
    const auto count = static_cast<int>(mesh.vertices.size());
    for (int i = 1 + below(40); i > 0; --i) mesh.triangles.emplace_back(below(count), below(count), below(count));

    std::vector<Vector3d> places;
    std::vector<Eigen::Vector3i> triangles = mesh.triangles;
    std::vector<int> number;
    for (const Vector3d& v : mesh.vertices) {
      number.push_back(static_cast<int>(std::find(places.begin(), places.end(), v) - places.begin()));
      if (number.back() == static_cast<int>(places.size())) places.push_back(v);
    }
    for (auto& t : triangles)
      for (int& i : t) i = number[static_cast<std::size_t>(i)];
    const TriangleMesh joined = welded(mesh);
    REQUIRE(joined.vertices == places);
    REQUIRE(joined.triangles == triangles);

    int duplicated = 0, boundary = 0, non_manifold = 0, inconsistent = 0;
    const auto corners = [](Eigen::Vector3i t) { return std::sort(t.begin(), t.end()), t; };
    for (std::size_t i = 0; i < triangles.size(); ++i)
      duplicated += std::any_of(triangles.begin(), triangles.begin() + static_cast<std::ptrdiff_t>(i),
                                [&](const auto& other) { return corners(other) == corners(triangles[i]); });
    for (int a = 0; a < count; ++a)
      for (int b = a + 1; b < count; ++b) {
        int forward = 0, backward = 0;
        for (const auto& t : triangles)
          for (int k = 0; k < 3 && t[0] != t[1] && t[1] != t[2] && t[2] != t[0]; ++k) {
            forward += t[k] == a && t[(k + 1) % 3] == b;
            backward += t[k] == b && t[(k + 1) % 3] == a;
          }
        boundary += forward + backward == 1;
        non_manifold += forward + backward > 2;
        inconsistent += forward + backward == 2 && forward != 1;
      }
    const MeshProperties found = inspect(mesh);
    REQUIRE(found.duplicated == duplicated);
    REQUIRE(found.boundary_edges == boundary);
    REQUIRE(found.non_manifold_edges == non_manifold);
    REQUIRE(found.inconsistent_edges == inconsistent);
  }
}

TEST_CASE("the checksum names a surface", "[mesh]") {
  const TriangleMesh a = triangulate(Cone{}, 4);
  TriangleMesh b = a;
  CHECK(surface_checksum(a) == surface_checksum(b));
  b.vertices[3].x() += 1e-6;
  CHECK(surface_checksum(a) != surface_checksum(b));
  b.vertices[3] = a.vertices[3] * (1.0 + 1e-15);  // another compiler's last digit
  CHECK(surface_checksum(a) == surface_checksum(b));
}
