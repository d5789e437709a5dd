#include <catch2/catch.hpp>
#include <dragcore/mesh_file.hpp>

#include "cfd_cases/flow_case/solve.hpp"
#include "cfd_cases/mesh/snappy.hpp"
#include "tests/cfd_cases/temporary_folder.hpp"

using namespace cfd_cases;
using Catch::Matchers::Contains;
using Eigen::Vector3d;

namespace {

const std::filesystem::path kBodies = std::filesystem::path(SOURCE_FOLDER) / "cfd_cases/bodies";

dragcore::MeshBody committed(const std::string& name) {
  return dragcore::mesh_body(name, dragcore::read_mesh(kBodies / (name + ".stl")), 1.0, 1.0);
}

/// A cube of side 1 as its own mesh would be walled: six squares, with faces for the edges of the air besides.
PolyMesh walled_cube() {
  PolyMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.points.emplace_back((i & 1) - 0.5, ((i >> 1) & 1) - 0.5, ((i >> 2) & 1) - 0.5);
  // Out of the air: into the body.
  mesh.faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (auto& face : mesh.faces) std::reverse(face.begin(), face.end());
  for (const char* name : {"inlet", "outlet", "sides"}) {
    mesh.patches.push_back({name, static_cast<int>(mesh.faces.size()), 1});
    mesh.faces.push_back({0, 1, 3});
  }
  mesh.patches.push_back({"body", 0, 6});
  mesh.owner.assign(mesh.faces.size(), 0);
  return mesh;
}

const dragcore::MeshBody kCube = dragcore::mesh_body("block", dragcore::triangulate(dragcore::Box{}, 2), 1.0, 1.0);

/// Five of its six sides.
dragcore::MeshBody open_cube() {
  dragcore::TriangleMesh mesh = *kCube.mesh;
  std::erase_if(mesh.triangles, [&](const auto& t) {
    return mesh.vertices[static_cast<std::size_t>(t[0])].x() > 0.49 && mesh.vertices[static_cast<std::size_t>(t[1])].x() > 0.49 &&
           mesh.vertices[static_cast<std::size_t>(t[2])].x() > 0.49;
  });
  return dragcore::mesh_body("open_block", mesh, 1.0, 1.0);
}

}  // namespace

TEST_CASE("a mesh whose wall is the body's is accepted, and each way of missing it is refused", "[cfd_cases][mesh][hard]") {
  const MeshRecipe recipe;
  CHECK(snappy_fault(kCube, recipe, Symmetry::none, walled_cube()).empty());

  PolyMesh missed = walled_cube();
  missed.patches.back().faces = 0;
  CHECK_THAT(snappy_fault(kCube, recipe, Symmetry::none, missed), Contains("body has no faces") && Contains("missed"));

  PolyMesh inside = walled_cube();
  inside.patches.front().faces = 0;
  CHECK_THAT(snappy_fault(kCube, recipe, Symmetry::none, inside), Contains("inlet has no faces") && Contains("inside of the body"));

  PolyMesh shrunk = walled_cube();
  for (Vector3d& point : shrunk.points) point *= 0.99;  // 2 % of the area; 1.2 % is allowed
  CHECK_THAT(snappy_fault(kCube, recipe, Symmetry::none, shrunk), Contains("m2") && Contains("block"));

  PolyMesh open = walled_cube();
  open.patches.back().faces = 5;
  CHECK_THAT(snappy_fault(kCube, recipe, Symmetry::none, open), Contains("5 m2"));

  PolyMesh hollow = walled_cube();  // faces on both sides: what a closed body that lost a face becomes
  for (std::size_t i = 0; i < 3; ++i) std::reverse(hollow.faces[i].begin(), hollow.faces[i].end());
  CHECK_THAT(snappy_fault(kCube, recipe, Symmetry::none, hollow), Contains("m3"));

  PolyMesh torn =
      walled_cube();  // area and volume of a cube within the tolerance, but one corner of one face is not that of its neighbours
  torn.points.emplace_back(0.5, -0.497, 0.5);
  torn.faces[5] = {8, 7, 3, 1};
  CHECK_THAT(snappy_fault(kCube, recipe, Symmetry::none, torn), Contains("do not close"));

  // A shell: a sealed box in its place has a fifth too little wall and encloses what it should not.
  CHECK_THAT(snappy_fault(open_cube(), recipe, Symmetry::none, walled_cube()), Contains("two sides of the shell"));
}

TEST_CASE("the triangles of a body stand in the wind in their pose, all within the air", "[cfd_cases][mesh][sign]") {
  const auto files = snappy_files(committed("cup"), {.incidence = 3.14159265358979}, MeshRecipe{}, Symmetry::none);
  // The shell's pole is upstream at pose 0 (x = -0.25, from the centroid of the area), downstream when turned by 180 degrees.
  const std::string& stl = files.at("constant/triSurface/body.stl");
  CHECK(stl.find("vertex 0.24") != std::string::npos);
  CHECK(stl.find("vertex -0.25") == std::string::npos);
  CHECK_THAT(files.at("system/snappyHexMeshDict"), Contains("patchInfo { type wall; }") && Contains("locationInMesh (-"));
}

TEST_CASE("a shell and a closed body are meshed with both sides and their volume, as many cells as foreseen", "[cfd_cases][cfd]") {
  // Meshing alone, about 3 s each. Coarse cells: the allowed error of the area is that of faces of 0.07 on round walls.
  const Tools tools = find_tools(CFD_MESH_PROGRAM);
  const std::atomic<bool> never = false;
  for (const std::string name : {"cup", "l_bracket"}) {
    const TemporaryFolder folder;
    CAPTURE(name);
    CaseSpec spec;
    spec.shape = committed(name);
    spec.pose.incidence = name == "cup" ? 0.0 : 45.0;
    spec.mesh_level = "coarse";
    const Cache cache{folder.path};
    cache.make_folders();
    const auto identity = identify(spec, tools);
    CHECK(identity.symmetry == Symmetry::plane_y);
    const Mesh mesh = ensure_mesh(spec, identity, tools, cache, cache.work(identity.key), never, [](const char*) {});
    const auto measured = dragcore::properties(spec.shape);
    const bool shell = measured.volume == 0.0;
    CHECK(mesh.surface_area == Approx((shell ? 2.0 : 1.0) * measured.area).epsilon(0.024));
    CHECK(mesh.surface_volume == Approx(measured.volume).margin(0.024 * (shell ? measured.area : measured.volume)));
    const auto& body = std::get<dragcore::MeshBody>(spec.shape);
    CHECK(snappy_cells(body, spec.pose.radians(), identity.recipe, identity.symmetry) == Approx(mesh.cells).epsilon(0.15));
  }
}
