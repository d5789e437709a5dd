#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <dragcore/mesh_file.hpp>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/support/zoo.hpp"

using namespace dragcore;
namespace fs = std::filesystem;
using Catch::Matchers::WithinRel;

namespace {

/// A folder of its own for each test, removed afterwards.
struct Folder {
  fs::path path = fs::temp_directory_path() / ("dragcore_mesh_file_" + std::to_string(std::random_device{}()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path / name, std::ios::binary) << text;
    return path / name;
  }
};

std::string ascii_stl(const TriangleMesh& mesh, int precision = 6) {
  std::ostringstream out;
  out.precision(precision);
  out << "solid thing\n";
  for (const auto& t : mesh.triangles) {
    out << "facet normal 0 0 0\n outer loop\n";
    for (const int i : t) out << "  vertex " << mesh.vertices[i].transpose() << "\n";
    out << " endloop\nendfacet\n";
  }
  out << "endsolid thing\n";
  return out.str();
}

}  // namespace

TEST_CASE("a mesh comes back from STL and OBJ files with its area, volume and topology", "[mesh][io]") {
  const Folder folder;
  const TriangleMesh cone = triangulate(Cone{}, 6);
  const MeshProperties exact = inspect(cone);
  SECTION("binary STL") { write_stl(folder.path / "cone.stl", cone); }
  SECTION("ascii STL") { folder.write("cone.stl", ascii_stl(cone)); }
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
  CHECK_THROWS_WITH(read_mesh(folder.write("short.stl", std::string("a\0c", 3))), Catch::Contains("only 3 bytes"));
  CHECK_THROWS_WITH(read_mesh(folder.write("empty.obj", "v 0 0 0\n")), Catch::Contains("empty.obj"));
  write_stl(folder.path / "cut.stl", triangulate(Box{}, 2));
  fs::resize_file(folder.path / "cut.stl", fs::file_size(folder.path / "cut.stl") - 30);
  CHECK_THROWS_WITH(read_mesh(folder.path / "cut.stl"), Catch::Contains("truncated") && Catch::Contains("48 triangles"));
  const auto text = ascii_stl(triangulate(Box{}, 1));
  CHECK_THROWS_WITH(read_mesh(folder.write("cut_ascii.stl", text.substr(0, text.size() / 2))), Catch::Contains("cut_ascii.stl"));
  std::string typo = text + ascii_stl(triangulate(Box{}, 12));
  typo.replace(typo.find("facet normal"), 12, "fzcet nxrmal");
  std::string message;
  try {
    read_mesh(folder.write("typo.stl", typo));
  } catch (const std::exception& error) {
    message = error.what();
  }
  CHECK(message.size() < 500);  // the importer quotes the rest of the file
  std::string poisoned = text;
  poisoned.replace(poisoned.find("vertex ") + 7, 4, "nan ");
  CHECK_THROWS_WITH(read_mesh(folder.write("nan.stl", poisoned)), Catch::Contains("nan.stl"));
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
                                  std::string("v 0 0 0 1\nv 4 0 0 2\nv 0 1 0 0.5\nf 1 2 3")}) {                             // weights
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
}

TEST_CASE("every way in which programs write the same cube reads as that cube, or is refused by its true name", "[mesh][io][invariance]") {
  const Folder folder;
  const std::string plain = ascii_stl(triangulate(Box{}, 1));
  std::string capitals = plain, returns;
  std::transform(capitals.begin(), capitals.end(), capitals.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  for (const char c : plain) returns += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const std::string name = plain.substr(0, plain.find('\n'));
  write_stl(folder.path / "binary.stl", triangulate(Box{}, 1));
  std::ifstream in(folder.path / "binary.stl", std::ios::binary);
  const std::string binary{std::istreambuf_iterator<char>(in), {}};
  std::string solid = binary;
  solid.replace(0, 5, "solid");
  const std::vector<std::string> files = {plain,
                                          capitals,
                                          returns,
                                          "\n" + plain,
                                          "\xEF\xBB\xBF" + plain,
                                          "  " + plain,
                                          name + std::string(250, 'x') + plain.substr(name.size()),
                                          plain + "; exported " + std::string(220, '-') + "\n",
                                          binary,
                                          solid,
                                          binary + "\n",
                                          binary + std::string(512 - binary.size() % 512, '\0')};
  for (const std::string& bytes : files) {
    INFO(bytes.substr(0, 40));
    const MeshProperties found = inspect(read_mesh(folder.write("cube.stl", bytes)));
    CHECK(found.closed);
    CHECK_THAT(found.area, WithinRel(6.0, 1e-6));  // single precision in the binary ones
    CHECK_THAT(found.volume, WithinRel(1.0, 1e-6));
  }
  CHECK(read_mesh_file(folder.write("cube.stl", binary)).notes.empty());
  CHECK_THAT(read_mesh_file(folder.write("cube.stl", binary + "\n")).notes.at(0),
             Catch::Contains("1 bytes after the last of its 12 triangles"));
  // Two solids are one mesh; at map coordinates text keeps its digits.
  CHECK(read_mesh(folder.write("two.stl", plain + plain)).triangles.size() == 24);
  const TriangleMesh far = transformed(triangulate(Sphere{.diameter = 1.0}, 8), Eigen::Matrix3d::Identity(), {512345.3, 4123456.7, 312.6});
  const MeshProperties there = inspect(read_mesh(folder.write("far.stl", ascii_stl(far, 17))));
  CHECK_THAT(there.area, WithinRel(inspect(triangulate(Sphere{.diameter = 1.0}, 8)).area, 1e-6));  // written with 17 digits: 1e-9 of 4e6 m
  CHECK(there.closed);
  // OBJ: weights and colours are ignored, the first with a note; a cap of 2,400 corners is split.
  const std::string square = "v 0 0 0 2\nv 1 0 0 2\nv 1 1 0 2\nv 0 1 0 2\nf 1 2 3 4\n";
  const MeshFile weighted = read_mesh_file(folder.write("w.obj", square));
  CHECK_THAT(inspect(weighted.mesh).area, WithinRel(1.0, 1e-14));
  CHECK_THAT(weighted.notes.at(0), Catch::Contains("weight"));
  std::string cap;
  for (int i = 0; i < 2400; ++i) {
    const double a = 2 * std::numbers::pi * i / 2400;
    cap += "v " + std::to_string(std::cos(a)) + " " + std::to_string(std::sin(a)) + " 0 0.2 0.4 1\n";
  }
  cap += "f";
  for (int i = 1; i <= 2400; ++i) cap += " " + std::to_string(i);
  const MeshProperties disc = inspect(read_mesh(folder.write("cap.obj", cap + "\n")));
  CHECK(disc.triangles == 2398);
  CHECK_THAT(disc.area, WithinRel(std::numbers::pi, 1e-5));  // a polygon of 2,400 corners, in six decimals
  CHECK_THROWS_WITH(read_mesh(folder.write("wide.obj", std::string("\xFF\xFEv\0", 4))), Catch::Contains("UTF-16"));
}
