#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cfd_cases/case_key.hpp"

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
  Tools newer = kTools;
  newer.openfoam = "2212";
  CHECK(identify(base, newer).key != key);
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
