#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <numbers>

#include "cfd_cases/flow_case/case_key.hpp"

using namespace cfd_cases;

namespace {

const Tools kTools{.cfd_mesh = "/somewhere/cfd_mesh", .environment = {}, .openfoam = "1912", .gmsh = "4.8.4"};

CaseSpec plate(double incidence) {
  CaseSpec spec;
  spec.shape = dragcore::Plate{};
  spec.pose.incidence = incidence;
  return spec;
}

}  // namespace

TEST_CASE("SHA-256 of the standard's own example", "[cfd_cases][key][analytic]") {
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST_CASE("a key changes with all that determines a result", "[cfd_cases][key]") {
  const CaseSpec base = plate(30.0);
  const std::string key = identify(base, kTools).key;
  const auto changed = [&](auto change) {
    CaseSpec spec = base;
    change(spec);
    return identify(spec, kTools).key != key;
  };
  CHECK(changed([](CaseSpec& s) { s.pose.incidence = 30.5; }));
  CHECK(changed([](CaseSpec& s) { s.shape = dragcore::Plate{.thickness = 0.06}; }));
  CHECK(changed([](CaseSpec& s) { s.reynolds = 1.1e5; }));
  CHECK(changed([](CaseSpec& s) { s.flow_model = "laminar"; }));
  CHECK(changed([](CaseSpec& s) { s.mesh_level = "fine"; }));
  CHECK(changed([](CaseSpec& s) { s.numerics.relaxation_pressure = 0.7; }));
  CHECK(changed([](CaseSpec& s) { s.numerics.viscosity_ratio = 1.0; }));
  CHECK(changed([](CaseSpec& s) { s.stop.max_iterations = 900; }));
  CHECK(changed([](CaseSpec& s) { s.retries = 0; }));
  CHECK(changed([](CaseSpec& s) { s.numerics.wall = "low_re"; }));
  CHECK(changed([](CaseSpec& s) { s.recipe.sideways = 12.0; }));
  CHECK(changed([](CaseSpec& s) { s.recipe.seed = 2.0; }));
  CHECK(changed([](CaseSpec& s) { s.recipe.far_radius = 8.0; }));
  CHECK(changed([](CaseSpec& s) { s.half_model = false; }));
  CHECK(changed([](CaseSpec& s) { s.spin.axis = "y"; }));
  CHECK(changed([](CaseSpec& s) { s.start = std::make_shared<CaseSpec>(plate(45.0)); }));
  Tools newer = kTools;
  newer.openfoam = "2212";
  CHECK(identify(base, newer).key != key);
}

TEST_CASE("the key of a body of triangles changes with every one of them", "[cfd_cases][key]") {
  dragcore::TriangleMesh mesh = dragcore::triangulate(dragcore::Cone{}, 2);
  const auto key_of = [&](double area) {
    CaseSpec spec;
    spec.shape = dragcore::mesh_body("hat", mesh, area, 1.0);
    const CaseIdentity identity = identify(spec, kTools);
    CHECK_FALSE(described_case(identity.description).has_value());  // the triangles are not in it
    return identity.key;
  };
  const std::string key = key_of(1.0);
  CHECK(key_of(1.0) == key);
  CHECK(key_of(2.0) != key);
  mesh.vertices[3] *= 1.0 + 1e-6;
  CHECK(key_of(1.0) != key);
}

TEST_CASE("a key does not change with where, how fast and for whom a case is solved", "[cfd_cases][key][invariance]") {
  const std::string key = identify(plate(30.0), kTools).key;
  CaseSpec spec = plate(30.0);
  spec.name = "anything";
  spec.tier = "reference";
  spec.held_out = true;
  spec.timeout_s = 3.0;
  Tools elsewhere = kTools;
  elsewhere.cfd_mesh = "/elsewhere/cfd_mesh";
  elsewhere.environment["WM_PROJECT_DIR"] = "/opt/openfoam";
  CHECK(identify(spec, elsewhere).key == key);
  // Ranks cannot change it: they are not part of a CaseSpec, and no generated file of the key mentions them.
  CHECK(identify(spec, kTools).description.find("numberOfSubdomains") == std::string::npos);
}

TEST_CASE("the dual's angle follows the shape only where 60 degrees would bevel an edge", "[cfd_cases][key][limit]") {
  const auto angle = [](const dragcore::Shape& shape) {
    CaseSpec spec;
    spec.shape = shape;
    return identify(spec, kTools).recipe.dual_feature_angle_deg;
  };
  constexpr double degree = std::numbers::pi / 180.0;
  for (const dragcore::Shape& shape :
       {dragcore::Shape(dragcore::Plate{}), dragcore::Shape(dragcore::Box{}), dragcore::Shape(dragcore::Cone{}),
        dragcore::Shape(dragcore::Prism{}), dragcore::Shape(dragcore::Prism{.apex_angle = 119.0 * degree})})
    CHECK(angle(shape) == 60.0);
  CHECK(angle(dragcore::Prism{.apex_angle = 150.0 * degree}) == Approx(27.0).epsilon(1e-12));
  // A stored description says the same again.
  CaseSpec spec;
  spec.shape = dragcore::Prism{.apex_angle = 150.0 * degree};
  const CaseIdentity once = identify(spec, kTools);
  spec.recipe.dual_feature_angle_deg = once.recipe.dual_feature_angle_deg;
  CHECK(identify(spec, kTools).key == once.key);
}

TEST_CASE("new choices that are not made leave old keys as they were", "[cfd_cases][key][regression]") {
  // The committed references hold this key; a campaign that goes on from them would otherwise solve all of them again.
  CaseSpec spec = plate(90.0);
  spec.stop.max_iterations = 1500;
  CHECK(identify(spec, kTools).key == "13c26bf1fd87897a68ec8b2fd090b244fb39261854e4385e456bf0d84bdab63f");
}

TEST_CASE("a chain of starts is part of the key, from its first case on", "[cfd_cases][key]") {
  CaseSpec second = plate(45.0), third = plate(60.0);
  second.start = std::make_shared<CaseSpec>(plate(30.0));
  third.start = std::make_shared<CaseSpec>(second);
  const auto id = identify(third, kTools);
  CHECK(id.start_key == identify(second, kTools).key);
  CaseSpec otherwise = third;
  second.start = std::make_shared<CaseSpec>(plate(31.0));
  otherwise.start = std::make_shared<CaseSpec>(second);
  CHECK(identify(otherwise, kTools).key != id.key);
}

TEST_CASE("where the wind turns, poses share a mesh, and its frame is the body's", "[cfd_cases][key]") {
  CaseSpec a = plate(30.0), b = plate(45.0);
  for (CaseSpec* spec : {&a, &b}) spec->recipe = octree_recipe();
  CHECK(identify(a, kTools).mesh_key == identify(b, kTools).mesh_key);
  CHECK(identify(a, kTools).key != identify(b, kTools).key);
  CHECK(identify(a, kTools).symmetry == Symmetry::plane_y);
  CHECK((identify(a, kTools).to_wind - a.pose.radians().rotation()).norm() == 0.0);
  // The diagonal plane of a cube at 45 degrees is no plane of its mesh; the other one is.
  CaseSpec cube;
  cube.shape = dragcore::Box{};
  cube.pose.yaw = 45.0;
  CHECK(identify(cube, kTools).symmetry == Symmetry::plane_y);
  cube.turn_wind = true;
  CHECK(identify(cube, kTools).symmetry == Symmetry::plane_z);
  // The flow about a sphere is symmetric in every pose, but about no plane of its own axes.
  CaseSpec sphere;
  sphere.shape = dragcore::Sphere{};
  sphere.pose = {.incidence = 30.0, .yaw = 20.0};
  sphere.turn_wind = true;
  CHECK(identify(sphere, kTools).symmetry == Symmetry::none);
}

TEST_CASE("flows of the same body in the same pose share one mesh", "[cfd_cases][key]") {
  CaseSpec laminar = plate(30.0);
  laminar.reynolds = 100.0;
  laminar.flow_model = "laminar";
  const auto a = identify(plate(30.0), kTools), b = identify(laminar, kTools);
  CHECK(a.mesh_key == b.mesh_key);
  CHECK(a.key != b.key);
  CHECK(identify(plate(45.0), kTools).mesh_key != a.mesh_key);
  CHECK(nlohmann::json::parse(a.description).at("mesh") == nlohmann::json::parse(a.mesh_description));
}

TEST_CASE("a stored description tells of an O-grid and of how good a mean had to be; others do not mention them", "[cfd_cases][key]") {
  CaseSpec spec;
  spec.shape = dragcore::Sphere{};
  CHECK_THAT(identify(spec, kTools).description, !Catch::Contains("mean_error") && !Catch::Contains("first_layer"));
  spec.flow_model = "k_omega_sst_lm";
  spec.recipe = o_grid_recipe();
  spec.stop = stop_policy_of(spec.flow_model);
  const auto known = described_case(identify(spec, kTools).description);
  REQUIRE(known);
  CHECK(known->spec.o_grid());
  CHECK(known->spec.stop.mean_error == 0.03);
}
