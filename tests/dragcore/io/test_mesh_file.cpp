#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cctype>
#include <dragcore/mesh_file.hpp>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string_view>
#include <thread>

#include "tests/support/folder.hpp"
#include "tests/support/mesh_files.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using mesh_files::Ascii;
using mesh_files::Binary;
using mesh_files::ObjCube;
using support::Folder;
namespace fs = std::filesystem;
using Catch::Matchers::WithinRel;

namespace {

void check_cube(const fs::path& file) {
  INFO(file);
  const MeshProperties found = inspect(read_mesh(file));
  CHECK(found.closed);
  CHECK(found.triangles == 12);
  CHECK_THAT(found.area, WithinRel(6.0, 1e-15));  // its corners are exact numbers
  CHECK_THAT(found.volume, WithinRel(1.0, 1e-15));
}

using Notes = std::vector<std::string>;

}  // namespace

TEST_CASE("a mesh comes back from STL and OBJ files with its area, volume and topology", "[mesh][io]") {
  const Folder folder;
  const TriangleMesh cone = triangulate(Cone{}, 6);
  const MeshProperties exact = inspect(cone);
  SECTION("binary STL") { write_stl(folder.path / "cone.stl", cone); }
  SECTION("ascii STL") { folder.write("cone.stl", Ascii{.mesh = cone}.text()); }
  const MeshProperties found = inspect(read_mesh(folder.path / "cone.stl"));
  CHECK(found.closed);
  CHECK(found.consistently_wound);
  CHECK(found.triangles == exact.triangles);
  CHECK_THAT(found.area, WithinRel(exact.area, 1e-5));  // six digits of text, seven of a float
  CHECK_THAT(found.volume, WithinRel(exact.volume, 1e-5));
}

TEST_CASE("polygons of an OBJ file are split and its unit is honoured", "[mesh][io]") {
  const Folder folder;
  const auto file =
      folder.write("cube.obj",
                   "v 0 0 0\nv 1000 0 0\nv 1000 1000 0\nv 0 1000 0\nv 0 0 1000\nv 1000 0 1000\nv 1000 1000 1000\nv 0 1000 1000\n"
                   "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  const MeshProperties found = inspect(read_mesh(file, 0.001));
  CHECK(found.triangles == 12);
  CHECK(found.closed);
  CHECK_THAT(found.volume, WithinRel(1.0, 1e-6));
}

TEST_CASE("a damaged mesh file is refused with its name and its fault", "[mesh][io][hard]") {
  const Folder folder;
  CHECK_THROWS_WITH(read_mesh(folder.path / "absent.stl"), Catch::Contains("absent.stl") && Catch::Contains("no such file"));
  CHECK_THROWS_WITH(read_mesh(folder.write("thing.step", "ISO-10303")), Catch::Contains("unknown kind '.step'"));
  CHECK_THROWS_WITH(read_mesh(folder.write("short.stl", "abc")), Catch::Contains("no line begins with 'solid'"));
  CHECK_THROWS_WITH(read_mesh(folder.write("short.stl", std::string("\1\0\2", 3))), Catch::Contains("only 3 bytes"));
  CHECK_THROWS_WITH(read_mesh(folder.write("empty.obj", "v 0 0 0\n")), Catch::Contains("empty.obj"));
  write_stl(folder.path / "cut.stl", triangulate(Box{}, 2));
  fs::resize_file(folder.path / "cut.stl", fs::file_size(folder.path / "cut.stl") - 30);
  CHECK_THROWS_WITH(read_mesh(folder.path / "cut.stl"), Catch::Contains("truncated") && Catch::Contains("48 triangles"));
  const auto text = Ascii{}.text();
  CHECK_THROWS_WITH(read_mesh(folder.write("cut_ascii.stl", text.substr(0, text.size() / 2))), Catch::Contains("cut_ascii.stl"));
}

TEST_CASE("an OBJ file that names another file does not make the reader open it", "[mesh][io][hard][regression]") {
  const Folder folder;
  // A material library that is a pipe nobody writes to: opening it waits for ever.
  REQUIRE(::mkfifo((folder.path / "pipe").c_str(), 0600) == 0);
  const auto file = folder.write("named.obj", "mtllib " + (folder.path / "pipe").string() + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  std::atomic<bool> opened = false;
  std::thread writer([&] {
    const int end = ::open((folder.path / "pipe").c_str(), O_WRONLY);  // returns when somebody has opened the other end
    opened = true;
    ::close(end);
  });
  CHECK(read_mesh(file).triangles.size() == 1);
  CHECK_FALSE(opened);
  const int end = ::open((folder.path / "pipe").c_str(), O_RDONLY | O_NONBLOCK);  // lets the writer go
  writer.join();
  ::close(end);
}

TEST_CASE("of an OBJ file only vertices and faces count, however they are written", "[mesh][io]") {
  const Folder folder;
  const auto area = [&](const std::string& text) { return inspect(read_mesh(folder.write("face.obj", text))).area; };
  const std::string corners = "v 0 0 0\nv 2 0 0\nv 0 2 0\n";
  for (const std::string& text : {corners + "f 1 2 3", corners + "f -3 -2 -1\r\n", "f 1 2 3\n" + corners, corners + "f 1 \\\n 2 \\\r\n3\n",
                                  corners + "vt 0 0\nvn 0 0 1\no thing\ng a b\nusemtl red\ns off\nf 1/1/1 2//1 3/1\nl 1 2 3\np 1\nf 1 2\n",
                                  std::string("# comment\nv 0 0 0 1 0 0\nv +2.0e0 0 0 0.5 1 1\n\tv 0 2 0 0 0 1\nf 1 2 3"),  // colours
                                  std::string("v 0 0 0 1\nv 4 0 0 2\nv 0 1 0 0.5\nf 1 2 3"),                                // weights
                                  "\xEF\xBB\xBF" + corners + "f 1 2 3 # a comment", std::string("v 0 0 0\rv 2 0 0\rv 0 2 0\rf 1 2 3\r")}) {
    INFO(text);
    CHECK(area(text) == 2.0);
  }
}

TEST_CASE("a polygon of an OBJ file has its area once it is split, convex or not, and joins its neighbours", "[mesh][io][analytic]") {
  const Folder folder;
  const auto read = [&](const std::vector<Eigen::Vector3d>& corners, const Eigen::Matrix3d& rotation) {
    std::ostringstream text;
    text.precision(17);
    for (const auto& corner : corners) text << "v " << (rotation * corner).transpose() << "\n";
    text << "f";
    for (std::size_t i = 0; i < corners.size(); ++i) text << " " << i + 1;
    return inspect(read_mesh(folder.write("polygon.obj", text.str())));
  };
  struct Case {
    std::vector<Eigen::Vector3d> corners;
    double area;
  };
  std::vector<Eigen::Vector3d> star;  // corners 2 and 1 from the middle by turns: ten triangles of sin 36 deg
  for (int i = 0; i < 10; ++i)
    star.emplace_back((2 - i % 2) * std::cos(i * std::numbers::pi / 5), (2 - i % 2) * std::sin(i * std::numbers::pi / 5), 0.0);
  const Case cases[] = {
      {{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, 4.0},
      {{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}, 3.0},  // an L: its inner corner lies on a diagonal
      {{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 1, 0}, {0, 2, 0}}, 3.0},             // a square with a notch to its middle
      {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, 4.0},             // a corner that is none
      {star, 10 * std::sin(36 * std::numbers::pi / 180)}};
  zoo::Random random(11);
  for (const Case& test : cases) {
    std::vector<Eigen::Vector3d> corners = test.corners;
    for (std::size_t start = 0; start < corners.size(); ++start) {
      std::rotate(corners.begin(), corners.begin() + 1, corners.end());
      const MeshProperties found = read(corners, random.rotation());
      INFO(corners.size() << " corners from " << start);
      CHECK_THAT(found.area, WithinRel(test.area, 1e-14));  // rounding; overlaps would add to it
      CHECK(found.triangles == static_cast<int>(corners.size()) - 2);
      CHECK(found.boundary_edges == static_cast<int>(corners.size()));  // every edge of the polygon is one of a triangle
      CHECK(found.consistently_wound);
    }
  }
  // Edges that cross, corners on a line: any split will do.
  CHECK(read({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}, Eigen::Matrix3d::Identity()).triangles == 2);
  CHECK(read({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, Eigen::Matrix3d::Identity()).area == 0.0);
}

TEST_CASE("an OBJ file whose numbers do not fit each other is refused with line, value found and value needed",
          "[mesh][io][hard][regression]") {
  const Folder folder;
  const auto refused = [&](const std::string& text, const std::string& what) {
    INFO(text);
    CHECK_THROWS_WITH(read_mesh(folder.write("bad.obj", text)), Catch::Contains("bad.obj: ") && Catch::Contains(what));
  };
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  refused("", "is empty");
  refused(corners, "holds no triangle");
  refused(corners + "f 1 2\n", "holds no triangle");
  refused(corners + "f 1 2 4\n", "line 4: a face refers to vertex 4, but there are 3");
  refused(corners + "f 1/1 2/2 2147483647/1\n", "line 4: a face refers to vertex 2147483647, but there are 3");
  refused(corners + "f 0 1 2\n", "line 4: a face refers to vertex 0");
  refused(corners + "\nf -4 1 2\n", "line 5: a face refers to vertex -4, of 3 so far");
  refused(corners + "f 1 2 /3\n", "line 4: a corner of a face is '/3'");
  refused(corners + "f 1 2 2147483648\n", "needed: the number of a vertex");
  refused("v 0 0\nf 1 1 1", "line 1: a vertex has 2 coordinates; needed: three");
  refused("v 0 0 1x\nf 1 1 1", "line 1: a coordinate of a vertex is '1x'; needed: a finite number");
  refused("v 0 nan 0\nf 1 1 1", "is 'nan'; needed: a finite number");
  refused("v 0 0 -1e309\nf 1 1 1", "is '-1e309'; needed: a finite number");
  refused("v 0 0 1 w\nf 1 1 1", "line 1: the weight of a vertex is 'w'; needed: a finite number");
  refused("v 0 0 \x1b[31m\nf 1 1 1", R"(line 1: a coordinate of a vertex is '\x1b[31m'; needed: a finite number)");
  refused("v 0 0 '\\'\nf 1 1 1", R"(is '\'\\\'')");
  refused("v 0 0 " + std::string(5000, 'x') + "\nf 1 1 1", "line 1: a coordinate of a vertex is '" + std::string(40, 'x') + "…'; needed");
  refused(std::string("\xFF\xFEv\0 \0", 6), "is text in UTF-16; save it as UTF-8 or ASCII");
  refused(std::string("v\0 \0", 4), "is text in UTF-16");
  refused(std::string("\0v\0 ", 4), "is text in UTF-16");
  CHECK_THROWS_WITH(read_mesh(folder.write("large.obj", "v 0 0 1e308\nf 1 1 1"), 10.0), Catch::Contains("coordinates must be finite"));
  CHECK_THROWS_WITH(read_mesh(folder.path / "large.obj", 0.0), Catch::Contains("unit_m = 0.0"));
}

// What most programs write is in tests/dragcore/exposure/test_files_as_users_have_them.cpp; here is the rest.
TEST_CASE("the same cube in rare dialects of ascii STL is the same cube", "[mesh][io][regression]") {
  const Folder folder;
  const Ascii cases[] = {
      {.name = ""}, {.name = "facet normal endsolid"}, {.name = "K\xC3\xB6rper"}, {.before = "\xEF\xBB\xBF \r\n\t"}, {.line_end = "\r"}};
  for (const Ascii& test : cases) {
    INFO(test.text().substr(0, 80));
    const fs::path file = folder.write("cube.stl", test.text());
    check_cube(file);
    CHECK(read_mesh_file(file).notes.empty());
  }
  // The normal is of no account, nor whether it is there.
  std::string without_normals = Ascii{}.text();
  for (std::size_t at; (at = without_normals.find(" normal 0 0 0")) != std::string::npos;) without_normals.erase(at, 13);
  check_cube(folder.write("cube.stl", without_normals));
  std::string undefined_normals = Ascii{}.text();
  for (std::size_t at; (at = undefined_normals.find("0 0 0\n outer")) != std::string::npos;)
    undefined_normals.replace(at, 5, "nan -nan(ind) nan");
  check_cube(folder.write("cube.stl", undefined_normals));

  TriangleMesh first = triangulate(Box{}, 1), second = first;
  first.triangles.resize(5);
  second.triangles.erase(second.triangles.begin(), second.triangles.begin() + 5);
  const fs::path two = folder.write("cube.stl", Ascii{.mesh = first}.text() + Ascii{.name = "lid", .mesh = second}.text());
  check_cube(two);
  CHECK(read_mesh_file(two).notes == Notes{"solids: 2, read as one mesh"});
}

TEST_CASE("ascii STL keeps the double precision of its text", "[mesh][io][analytic][regression]") {
  // At map coordinates, where a float's step is 0.03 to 0.5 m: triangles of a ball of 1 m once came back with other areas, or none.
  const Folder folder;
  const TriangleMesh ball = transformed(triangulate(Sphere{.diameter = 1.0}, 8), Eigen::Matrix3d::Identity(), {512345.3, 4123456.7, 312.6});
  const TriangleMesh read = read_mesh(folder.write("utm.stl", Ascii{.mesh = ball}.text()));
  REQUIRE(read.triangles.size() == ball.triangles.size());
  for (std::size_t t = 0; t < read.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      CHECK(read.vertices[static_cast<std::size_t>(read.triangles[t][k])] == ball.vertices[static_cast<std::size_t>(ball.triangles[t][k])]);
}

TEST_CASE("binary STL is known by its size, whatever its header and its end say", "[mesh][io][regression]") {
  const Folder folder;
  const auto read = [&](const std::string& header, const std::string& tail) {
    const fs::path file = folder.write("cube.stl", Binary{.header = header, .tail = tail}.bytes());
    check_cube(file);
    return read_mesh_file(file).notes;
  };
  CHECK(read("\xFF\xFE", "").empty());  // not the mark of UTF-16
  CHECK(read("solid cube facet normal", "\n") == Notes{"bytes after the last of its 12 triangles: 1, ignored"});
  CHECK(read("", std::string(100, '\0')) == Notes{"bytes after the last of its 12 triangles: 100, ignored"});
  CHECK(read("", std::string(100, 'x')) == Notes{"bytes after the last of its 12 triangles: 100, ignored. They have the size of whole "
                                                 "triangles, 2: if some are missing, the count in its header is wrong"});
}

TEST_CASE("an STL file that is cut, foreign or wrong is refused with line or triangle, value found and value needed",
          "[mesh][io][hard][regression]") {
  const Folder folder;
  const auto refused = [&](const std::string& bytes, const std::string& what) {
    INFO(bytes.substr(0, 200));
    std::string message;
    try {
      read_mesh(folder.write("bad.stl", bytes));
    } catch (const std::runtime_error& fault) {
      message = fault.what();
    }
    CHECK_THAT(message, Catch::Contains("bad.stl: ") && Catch::Contains(what));
    CHECK(message.size() < 300);
  };
  const std::string text = Ascii{}.text(), large = text + Ascii{.mesh = triangulate(Box{}, 12)}.text();
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string result = large;
    return result.replace(result.find(from), from.size(), to);
  };
  refused("", "is empty");
  refused(changed("facet normal", "fzcet nxrmal"), "line 2: 'fzcet' where 'facet' or 'endsolid' is needed");
  refused(changed("outer", "inner"), "line 3: 'inner' where 'outer' is needed");
  refused(changed("loop", "spool"), "line 3: 'spool' where 'loop' is needed");
  refused(changed("vertex", "vortex"), "line 4: 'vortex' where 'vertex' is needed");
  refused(changed("vertex ", "vertex nan "), "line 4: 'nan' where a coordinate, a finite number, is needed");
  refused(changed("vertex ", "vertex 1,5 "), "line 4: '1,5' where a coordinate");
  refused(changed("vertex ", "vertex \x1b[2J "), R"(line 4: '\x1b[2J' where a coordinate)");
  refused(changed("vertex ", "vertex 1e999 "), "line 4: '1e999' where a coordinate");
  refused(changed("vertex ", "vertex 1 "), "line 4: '-0.5' where 'vertex' is needed");
  refused(changed(" endloop\n", "  vertex 0 0 0\n endloop\n"), "line 7: 'vertex' where 'endloop' is needed");
  refused(changed("endfacet\n", ""), "line 8: 'facet' where 'endfacet' is needed");
  refused(changed("endsolid body\n", ""), "line 86: 'solid' where 'facet' or 'endsolid' is needed");
  refused(text + "facet normal 0 0 0\n", "line 87: 'facet' where 'solid' before it is needed");
  refused("solid\nendsolid\n", "holds no triangle");
  refused("ISO-10303-21;\nHEADER;\n", "is text in which no line begins with 'solid'; it is no STL file");
  refused(std::string("\xFF\xFEs\0o\0l\0i\0d\0", 12), "is text in UTF-16; save it as UTF-8 or ASCII");
  refused(std::string("s\0o\0l\0i\0d\0", 10), "is text in UTF-16");
  refused(std::string("\1\0\2", 3), "only 3 bytes; a binary STL file has at least 84");
  // Every cut of a whole text, but for its last line's end and the name that the last solid need not repeat.
  for (std::size_t size = 1; size + std::string_view(" body\n").size() < text.size(); size += 3) refused(text.substr(0, size), "");
  refused(text.substr(0, text.size() - 14), "line 86: truncated: the file ends where 'facet' or 'endsolid' is needed. Export it again");

  const std::string binary = Binary{}.bytes();
  for (std::size_t size = 1; size < binary.size(); size += 7) refused(binary.substr(0, size), size < 84 ? "" : "Export it again");
  refused(binary.substr(0, binary.size() - 1), "its header promises 12 triangles, 684 bytes, but it has 683");
  std::string uncounted = binary, poisoned = binary;
  uncounted.replace(80, 4, std::string(4, '\0'));
  refused(uncounted, "holds no triangle: its header promises 0, though 600 bytes follow. Export it again");
  refused(uncounted.substr(0, 84), "holds no triangle: its header promises 0");
  poisoned.replace(84 + 50 + 12, 4, "\xFF\xFF\xFF\x7F");
  refused(poisoned, "triangle 2 of 12: a coordinate is nan; needed: a finite number. Export it again");
}

TEST_CASE("what is ignored in an OBJ file is said", "[mesh][io][regression]") {
  const Folder folder;
  check_cube(folder.write("cube.obj", ObjCube{.after_vertex = " 1"}.text()));
  CHECK(read_mesh_file(folder.path / "cube.obj").notes.empty());
  check_cube(folder.write("cube.obj", ObjCube{.after_vertex = " 0"}.text()));  // a weight of nothing puts no corner at infinity
  CHECK(read_mesh_file(folder.path / "cube.obj").notes ==
        Notes{"vertices with a weight w: 8, the first in line 1, ignored, for it matters to curves alone: x, y, z are taken as written"});
  check_cube(folder.write("cube.obj", ObjCube{}.text() + "f 1 2\n\nsurf 0 1 0 1 1 2 3 4\n"));
  CHECK(read_mesh_file(folder.path / "cube.obj").notes ==
        Notes{"faces of fewer than three corners: 1, the first in line 15, left out",
              "curved surfaces ('surf'): 1, the first in line 17, left out: export polygons"});
}

TEST_CASE("polygons may have any number of corners", "[mesh][io][analytic]") {
  const Folder folder;
  // Not convex: a gear, a comb and a spiral, in which an ear is far from the last one. Time with the cube of the corners would be minutes.
  const auto check = [&](const std::vector<Eigen::Vector2d>& corners) {
    std::ostringstream polygon;
    polygon.precision(17);
    double area = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % corners.size()];
      area += 0.5 * (a.x() * b.y() - a.y() * b.x());
      polygon << "v " << a.transpose() << " 0\n";
    }
    polygon << "f";
    for (std::size_t i = 0; i < corners.size(); ++i) polygon << " " << i + 1;
    const MeshProperties found = inspect(read_mesh(folder.write("polygon.obj", polygon.str())));
    CHECK_THAT(found.area, WithinRel(std::abs(area), 1e-10));  // sums of thousands, of terms larger than they
    CHECK(found.triangles == static_cast<int>(corners.size()) - 2);
    CHECK(found.boundary_edges == static_cast<int>(corners.size()));
    CHECK(found.consistently_wound);
  };
  constexpr int many = 4000;
  std::vector<Eigen::Vector2d> gear, comb{{0.0, 0.0}, {many - 1.0, 0.0}}, spiral;
  for (int i = 0; i < many; ++i) {
    const double angle = 2 * std::numbers::pi * i / many;
    gear.emplace_back((2 - i % 2) * std::cos(angle), (2 - i % 2) * std::sin(angle));
    comb.emplace_back(many - 1 - i, 1.5 + i % 2);
  }
  for (int i = 0; i < many / 2; ++i) spiral.emplace_back((1 + i / 200.0) * std::cos(i / 40.0), (1 + i / 200.0) * std::sin(i / 40.0));
  for (int i = many / 2 - 1; i >= 0; --i)
    spiral.emplace_back((1.3 + i / 200.0) * std::cos(i / 40.0), (1.3 + i / 200.0) * std::sin(i / 40.0));
  check(gear);
  check(comb);
  check(spiral);
  // A square with a square hole, joined by a slit as exporters write it: corners of the slit are there twice.
  const std::string ring = "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nv 1 1 0\nv 1 2 0\nv 2 2 0\nv 2 1 0\nf 1 2 3 4 1 5 6 7 8 5\n";
  CHECK(inspect(read_mesh(folder.write("ring.obj", ring))).area == 8.0);
}
