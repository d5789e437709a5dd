#include <catch2/catch.hpp>
#include <dragcore/mesh_file.hpp>
#include <filesystem>
#include <fstream>

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

std::string ascii_stl(const TriangleMesh& mesh) {
  std::ostringstream out;
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
  const auto file = folder.write("cube.obj",
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
  CHECK_THROWS_WITH(read_mesh(folder.write("short.stl", "abc")), Catch::Contains("only 3 bytes"));
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
