#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "cfd_cases/flow_case/dictionaries.hpp"

using namespace cfd_cases;
using Catch::Matchers::Contains;

namespace {

CaseSpec spec_of(const std::string& flow_model) {
  CaseSpec spec;
  spec.shape = dragcore::Plate{.chord = 2.0, .span = 1.0, .thickness = 0.05};
  spec.flow_model = flow_model;
  spec.reynolds = 1000.0;
  return spec;
}

}  // namespace

TEST_CASE("the viscosity is that of the Reynolds number on the reference length", "[cfd_cases][dictionaries][analytic]") {
  CHECK(kinematic_viscosity(spec_of("laminar")) == Approx(1.0 * 2.0 / 1000.0));
  CHECK_THAT(dictionaries(spec_of("laminar"), Symmetry::none, Rung::standard).at("constant/transportProperties"), Contains("nu 0.002;"));
}

TEST_CASE("a laminar case has no fields of turbulence, a turbulent one has wall functions", "[cfd_cases][dictionaries]") {
  const auto laminar = dictionaries(spec_of("laminar"), Symmetry::none, Rung::standard);
  CHECK_FALSE(laminar.contains("0/k"));
  CHECK_THAT(laminar.at("constant/turbulenceProperties"), Contains("laminar"));
  const auto turbulent = dictionaries(spec_of("k_omega_sst"), Symmetry::none, Rung::standard);
  CHECK_THAT(turbulent.at("0/nut"), Contains("nutUSpaldingWallFunction"));
  CHECK_THAT(turbulent.at("0/k"), Contains("kqRWallFunction") && Contains("uniform 0.00015"));  // 3/2 (1 %)^2
}

TEST_CASE("only a half model has a symmetry patch", "[cfd_cases][dictionaries]") {
  CHECK_THAT(dictionaries(spec_of("laminar"), Symmetry::plane_z, Rung::standard).at("0/U"), Contains("symmetry { type symmetry; }"));
  CHECK_THAT(dictionaries(spec_of("laminar"), Symmetry::none, Rung::standard).at("0/U"), !Contains("symmetry"));
}

TEST_CASE("the cautious rung relaxes more and never less than asked", "[cfd_cases][dictionaries]") {
  CHECK_THAT(dictionaries(spec_of("laminar"), Symmetry::none, Rung::standard).at("system/fvSolution"),
             Contains("U 0.85;") && Contains("p 0.8;"));
  CHECK_THAT(dictionaries(spec_of("laminar"), Symmetry::none, Rung::cautious).at("system/fvSolution"),
             Contains("U 0.6;") && Contains("p 0.5;"));
  Numerics gentle;
  gentle.relaxation_velocity = 0.3;
  CHECK(numerics_on(Rung::cautious, gentle).relaxation_velocity == 0.3);
}

TEST_CASE("gradients are unlimited unless a sensitivity study asks for the limiter", "[cfd_cases][dictionaries]") {
  CaseSpec spec = spec_of("k_omega_sst");
  CHECK_THAT(dictionaries(spec, Symmetry::none, Rung::standard).at("system/fvSchemes"),
             Contains("default Gauss linear;") && Contains("bounded Gauss linearUpwind grad(U)"));
  spec.numerics.gradient = "cell_limited";
  CHECK_THAT(dictionaries(spec, Symmetry::none, Rung::standard).at("system/fvSchemes"), Contains("default cellLimited Gauss linear 1;"));
}

TEST_CASE("forces are taken about the centroid and written at every iteration, and the solver heeds the stop file",
          "[cfd_cases][dictionaries]") {
  const std::string control = dictionaries(spec_of("laminar"), Symmetry::none, Rung::standard).at("system/controlDict");
  CHECK_THAT(control,
             Contains("CofR (0 0 0)") && Contains("patches (body)") && Contains("writeInterval 1;") && Contains("file \"<case>/stop\""));
  CHECK_THAT(decomposition(4), Contains("hierarchical") && Contains("n (4 1 1)"));
}

TEST_CASE("where the wind turns it meets the body at the angle of the pose", "[cfd_cases][dictionaries][sign]") {
  CaseSpec spec = spec_of("k_omega_sst");
  spec.recipe = octree_recipe();
  spec.pose.incidence = 30.0;  // the nose is lifted: the wind comes from below, towards +z of the body
  const Flow flow = flow_of(spec);
  CHECK(flow.wind.x() == Approx(std::cos(std::numbers::pi / 6.0)));
  CHECK(flow.wind.z() == Approx(0.5));
  const auto files = dictionaries(spec, Symmetry::plane_y, Rung::standard);
  CHECK_THAT(files.at("0/U"), Contains("farfield { type freestreamVelocity; freestreamValue uniform (0.866025") && !Contains("inlet {"));
}

TEST_CASE("a spin in still air has the rate that makes omega L the reference speed", "[cfd_cases][dictionaries][analytic]") {
  CaseSpec spec = spec_of("laminar");
  spec.spin.axis = "z";
  spec.recipe.far_radius = 8.0;
  CHECK(flow_of(spec).wind.isZero());
  CHECK((flow_of(spec).angular_velocity - Eigen::Vector3d(0.0, 0.0, 0.5)).norm() < 1e-15);  // chord 2, speed 1
  const auto still = dictionaries(spec, Symmetry::plane_z, Rung::standard);
  CHECK_THAT(still.at("constant/MRFProperties"), Contains("axis (0 0 1); omega 0.5;"));
  CHECK_THAT(still.at("system/fvSolution"), Contains("pRefCell 0;"));
  CHECK(solver_of(spec) == "simpleFoam");
  spec.spin.ratio = 2.0;
  const auto windy = dictionaries(spec, Symmetry::plane_z, Rung::standard);
  CHECK_THAT(windy.at("constant/dynamicMeshDict"), Contains("axis (0 0 1); omega 1;"));
  CHECK_FALSE(windy.contains("constant/MRFProperties"));
  CHECK_THAT(windy.at("0/U"), Contains("movingWallVelocity"));
  CHECK(solver_of(spec) == "pimpleFoam");
}

TEST_CASE("a transition model has its two fields, a quiet wind, a wall without turbulence and a first guess askew",
          "[cfd_cases][dictionaries]") {
  CaseSpec spec;
  spec.shape = dragcore::Sphere{};
  spec.flow_model = "k_omega_sst_lm";
  spec.numerics = numerics_of(spec.flow_model);
  spec.recipe = o_grid_recipe();
  const auto files = dictionaries(spec, Symmetry::plane_y, Rung::standard);
  CHECK_THAT(files.at("constant/turbulenceProperties"), Contains("RASModel kOmegaSSTLM;"));
  CHECK_THAT(files.at("0/gammaInt"), Contains("internalField uniform 1;") && Contains("body { type zeroGradient;"));
  // 1173.51 - 589.428 Tu + 0.2196 / Tu^2 at Tu = 0.1 %.
  CHECK_THAT(files.at("0/ReThetat"), Contains("internalField uniform 1136.5"));
  CHECK_THAT(files.at("0/k"), Contains("internalField uniform 1.5e-06;") && Contains("body { type fixedValue; value uniform 1e-12; }"));
  CHECK_THAT(files.at("0/nut"), Contains("nutLowReWallFunction"));
  CHECK_THAT(files.at("0/U"), Contains("internalField uniform (1 0 0.1);") && Contains("freestreamValue uniform (1 0 0);"));
  CHECK_THAT(dictionaries(spec, Symmetry::plane_z, Rung::standard).at("0/U"), Contains("internalField uniform (1 0.1 0);"));
  for (const char* file : {"system/fvSchemes", "system/fvSolution"})
    CHECK_THAT(files.at(file), Contains("gammaInt") && Contains("ReThetat"));
  // Nothing of it in the files of others, whose keys hold them.
  spec.flow_model = "k_omega_sst";
  for (const auto& [path, text] : dictionaries(spec, Symmetry::plane_y, Rung::standard)) {
    CHECK(path.find("gammaInt") == std::string::npos);
    CHECK_THAT(text, !Contains("ReThetat"));
  }
}
