#include "cfd_cases/flow_case/dictionaries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cfd_cases {

namespace {

/// Radius of the ball of cells that turns with the body, in body scales: the air beyond is at rest but for what little the spin throws out.
constexpr double kSpinningRadius = 2.5;

std::string header(const std::string& type, const std::string& name) {
  return fmt::format("FoamFile {{ version 2.0; format ascii; class {}; object {}; }}\n", type, name);
}

std::string control(const std::string& solver, int iterations, double step) {
  return header("dictionary", "controlDict") + fmt::format(R"foam(
application {2};
startFrom startTime;  startTime 0;
stopAt endTime;       endTime {3};
deltaT {4};
writeControl timeStep;  writeInterval {0};  purgeWrite 1;
writeFormat ascii;  writePrecision 12;  writeCompression off;
timeFormat general;  timePrecision 8;
runTimeModifiable false;
functions
{{
  forces {{ type forces; libs (forces); patches (body); rho rhoInf; rhoInf {1}; CofR (0 0 0); writeControl timeStep; writeInterval 1; log no; }}
  shear {{ type wallShearStress; libs (fieldFunctionObjects); patches (body); writeControl writeTime; log no; }}
  stop {{ type abort; libs (utilityFunctionObjects); file "<case>/stop"; action writeNow; }}
}}
)foam",
                                                           iterations, kDensity, solver, iterations * step, step);
}

std::string steady_schemes(const Numerics& n, bool transition) {
  // The limited gradient is kept for sensitivity studies only: it gets stuck or oscillates on bluff bodies.
  const std::string gradient = n.gradient == "unlimited" ? "Gauss linear" : "cellLimited Gauss linear 1";
  const std::string convection = n.convection == "linear_upwind" ? "linearUpwind grad(U)"
                                 : n.convection == "lust"        ? "LUST grad(U)"
                                                                 : n.convection;
  return header("dictionary", "fvSchemes") + fmt::format(R"foam(
ddtSchemes {{ default steadyState; }}
gradSchemes {{ default {0}; }}
divSchemes
{{
  default none;
  div(phi,U) bounded Gauss {1};
  div(phi,k) bounded Gauss limitedLinear 1;
  div(phi,omega) bounded Gauss limitedLinear 1;
{2}  div((nuEff*dev2(T(grad(U))))) Gauss linear;
}}
laplacianSchemes {{ default Gauss linear corrected; }}
interpolationSchemes {{ default linear; }}
snGradSchemes {{ default corrected; }}
wallDist {{ method meshWave; }}
)foam",
                                                         gradient, convection,
                                                         transition ? "  div(phi,gammaInt) bounded Gauss limitedLinear 1;\n"
                                                                      "  div(phi,ReThetat) bounded Gauss limitedLinear 1;\n"
                                                                    : "");
}

/// Second order in time. LUST is central by three quarters: upwind schemes damp the eddies that DDES is there to resolve.
std::string unsteady_schemes() {
  return header("dictionary", "fvSchemes") + R"foam(
ddtSchemes { default backward; }
gradSchemes { default Gauss linear; }
divSchemes
{
  default none;
  div(phi,U) Gauss LUST grad(U);
  div(phi,k) Gauss limitedLinear 1;
  div(phi,omega) Gauss limitedLinear 1;
  div((nuEff*dev2(T(grad(U))))) Gauss linear;
}
laplacianSchemes { default Gauss linear corrected; }
interpolationSchemes { default linear; }
snGradSchemes { default corrected; }
wallDist { method meshWave; }
)foam";
}

std::string unsteady_solution() {
  return header("dictionary", "fvSolution") + R"foam(
solvers
{
  "(p|pcorr)" { solver GAMG; smoother GaussSeidel; tolerance 1e-6; relTol 0.02; }
  "(p|pcorr)Final" { $p; relTol 0.01; }
  "(U|k|omega)" { solver PBiCGStab; preconditioner DILU; tolerance 1e-7; relTol 0.01; }
  "(U|k|omega)Final" { $U; }
}
PIMPLE { nOuterCorrectors 1; nCorrectors 2; nNonOrthogonalCorrectors 0; correctPhi no; }
)foam";
}

std::string steady_solution(const Numerics& n, bool closed, bool transition) {
  return header("dictionary", "fvSolution") + fmt::format(R"foam(
solvers
{{
  p {{ solver GAMG; smoother GaussSeidel; tolerance 1e-8; relTol 0.05; }}
  "(U|k|omega{4})" {{ solver PBiCGStab; preconditioner DILU; tolerance 1e-9; relTol 0.1; }}
}}
SIMPLE {{ consistent yes; nNonOrthogonalCorrectors 0;{3} }}
relaxationFactors
{{
  fields {{ p {0}; }}
  equations {{ U {1}; "(k|omega{4})" {2}; }}
}}
)foam",
                                                          n.relaxation_pressure, n.relaxation_velocity, n.relaxation_turbulence,
                                                          closed ? " pRefCell 0; pRefValue 0;" : "",
                                                          transition ? "|gammaInt|ReThetat" : "");
}

/// What a field is at the edges of the air: at inlet and outlet of a box (its sides slip), or all around a ball or an octree.
struct Edges {
  std::string inlet, outlet, farfield;
};

/// A boundary field; the slip sides and the symmetry plane are the same for all.
std::string field(const std::string& name, const std::string& type, const std::string& dimensions, const std::string& initial,
                  const Edges& edges, bool boxed, const std::string& body, Symmetry symmetry) {
  return header(type, name) + fmt::format("dimensions {};\ninternalField uniform {};\nboundaryField\n{{\n", dimensions, initial) +
         (boxed ? fmt::format("  inlet {{ {} }}\n  outlet {{ {} }}\n  sides {{ type slip; }}\n", edges.inlet, edges.outlet)
                : fmt::format("  farfield {{ {} }}\n", edges.farfield)) +
         fmt::format("  body {{ {} }}\n", body) + (symmetry == Symmetry::none ? "" : "  symmetry { type symmetry; }\n") + "}\n";
}

std::string words(const Eigen::Vector3d& v) {
  // Adding 0 turns -0 into 0, which would otherwise make another key.
  return fmt::format("({} {} {})", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
}

}  // namespace

double kinematic_viscosity(const CaseSpec& spec) { return kSpeed * dragcore::properties(spec.shape).reference_length / spec.reynolds; }

Flow flow_of(const CaseSpec& spec) {
  const Eigen::Matrix3d to_mesh =
      spec.mesh_in_body_frame() ? spec.pose.radians().rotation().transpose().eval() : Eigen::Matrix3d::Identity();
  Flow flow;
  if (!spec.spin.in_still_air()) flow.wind = to_mesh * Eigen::Vector3d(kSpeed, 0.0, 0.0);
  // In still air the reference speed is omega L_ref.
  const double rate = (spec.spin.ratio > 0.0 ? spec.spin.ratio : 1.0) * kSpeed / dragcore::properties(spec.shape).reference_length;
  flow.angular_velocity = rate * (to_mesh * spec.pose.radians().rotation() * spec.spin.direction());
  return flow;
}

std::string solver_of(const CaseSpec& spec) { return spec.time_accurate() ? "pimpleFoam" : "simpleFoam"; }

std::string to_string(Rung rung) { return rung == Rung::standard ? "standard" : "cautious"; }

Numerics numerics_on(Rung rung, const Numerics& asked) {
  Numerics n = asked;
  if (rung == Rung::cautious) {
    n.relaxation_velocity = std::min(n.relaxation_velocity, 0.6);
    n.relaxation_pressure = std::min(n.relaxation_pressure, 0.5);
    n.relaxation_turbulence = std::min(n.relaxation_turbulence, 0.4);
  }
  return n;
}

std::map<std::string, std::string> dictionaries(const CaseSpec& spec, Symmetry symmetry, Rung rung) {
  const double nu = kinematic_viscosity(spec);
  const Numerics numerics = numerics_on(rung, spec.numerics);
  const Flow flow = flow_of(spec);
  const bool laminar = spec.laminar(), transition = spec.flow_model == "k_omega_sst_lm", spins = !spec.spin.axis.empty(),
             still = spec.spin.in_still_air();
  const bool boxed = spec.recipe.far_radius == 0.0 && !spec.octree();
  std::map<std::string, std::string> files;
  if (spec.time_accurate()) {
    const double step = spec.time.step * dragcore::properties(spec.shape).reference_length / kSpeed;
    const int steps = static_cast<int>(std::lround(spec.time.duration / spec.time.step));
    files["system/controlDict"] = control("pimpleFoam", steps, step);
    files["system/fvSchemes"] = unsteady_schemes();
    files["system/fvSolution"] = unsteady_solution();
  } else {
    files["system/controlDict"] = control("simpleFoam", spec.stop.max_iterations * (rung == Rung::cautious ? 2 : 1), 1.0);
    files["system/fvSchemes"] = steady_schemes(numerics, transition);
    files["system/fvSolution"] = steady_solution(numerics, still, transition);
  }
  files["constant/transportProperties"] =
      header("dictionary", "transportProperties") + fmt::format("transportModel Newtonian;\nnu {};\n", nu);
  files["constant/turbulenceProperties"] =
      header("dictionary", "turbulenceProperties") +
      (laminar                            ? "simulationType laminar;\n"
       : spec.flow_model == "k_omega_sst" ? "simulationType RAS;\nRAS { RASModel kOmegaSST; turbulence on; printCoeffs off; }\n"
       : transition                       ? "simulationType RAS;\nRAS { RASModel kOmegaSSTLM; turbulence on; printCoeffs off; }\n"
                                          : "simulationType LES;\nLES { LESModel kOmegaSSTDDES; turbulence on; printCoeffs off; delta "
                                            "maxDeltaxyz; maxDeltaxyzCoeffs { deltaCoeff 2; } }\n");
  if (still) {
    files["constant/MRFProperties"] =
        header("dictionary", "MRFProperties") +
        fmt::format(
            "body {{ cellZone spinning; active yes; nonRotatingPatches (farfield symmetry); origin (0 0 0); axis {}; omega {}; }}\n",
            words(flow.angular_velocity.normalized()), flow.angular_velocity.norm());
    files["system/topoSetDict"] =
        header("dictionary", "topoSetDict") +
        fmt::format(
            "actions\n(\n  {{ name ball; type cellSet; action new; source sphereToCell; sourceInfo {{ centre (0 0 0); radius {}; }} }}\n"
            "  {{ name spinning; type cellZoneSet; action new; source setToCellZone; sourceInfo {{ set ball; }} }}\n);\n",
            kSpinningRadius * body_scale(spec.shape));
  } else if (spins) {
    files["constant/dynamicMeshDict"] =
        header("dictionary", "dynamicMeshDict") +
        fmt::format(
            "dynamicFvMesh dynamicMotionSolverFvMesh;\nmotionSolverLibs (fvMotionSolvers);\nmotionSolver solidBody;\n"
            "solidBodyMotionFunction rotatingMotion;\nrotatingMotionCoeffs {{ origin (0 0 0); axis {}; omega {}; }}\n",
            words(flow.angular_velocity.normalized()), flow.angular_velocity.norm());
  }

  const std::string wind = words(flow.wind);
  // inletOutlet: eddies that reach the outlet may draw air back in, at rest.
  // A transitional wake that starts symmetric stays so for hundreds of iterations: the first guess is askew, in the plane of symmetry.
  const Eigen::Vector3d askew = 0.1 * kSpeed * (symmetry == Symmetry::plane_z ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ());
  files["0/U"] =
      field("U", "volVectorField", "[0 1 -1 0 0 0 0]", transition ? words(flow.wind + askew) : wind,
            {"type fixedValue; value uniform " + wind + ";", "type inletOutlet; inletValue uniform (0 0 0); value uniform " + wind + ";",
             still ? "type fixedValue; value uniform (0 0 0);" : "type freestreamVelocity; freestreamValue uniform " + wind + ";"},
            boxed,
            still   ? "type fixedValue; value uniform (0 0 0);"
            : spins ? "type movingWallVelocity; value uniform (0 0 0);"
                    : "type noSlip;",
            symmetry);
  files["0/p"] = field("p", "volScalarField", "[0 2 -2 0 0 0 0]", "0",
                       {"type zeroGradient;", "type fixedValue; value uniform 0;",
                        still ? "type zeroGradient;" : "type freestreamPressure; freestreamValue uniform 0;"},
                       boxed, "type zeroGradient;", symmetry);
  if (laminar) return files;

  const double k = 1.5 * numerics.turbulence_intensity * numerics.turbulence_intensity * kSpeed * kSpeed;
  const double nut = numerics.viscosity_ratio * nu, omega = k / nut;
  const auto carried = [&](const char* name, const char* dimensions, double value, const char* wall, double on_wall) {
    const std::string in_or_out = fmt::format("type inletOutlet; inletValue uniform {0}; value uniform {0};", value);
    files[std::string("0/") + name] = field(name, "volScalarField", dimensions, fmt::format("{}", value),
                                            {fmt::format("type fixedValue; value uniform {};", value), in_or_out,
                                             still ? fmt::format("type fixedValue; value uniform {};", value) : in_or_out},
                                            boxed, fmt::format("type {}; value uniform {};", wall, on_wall), symmetry);
  };
  // Where a transition model resolves the wall, turbulence grows from nothing; 0 would be divided by.
  carried("k", "[0 2 -2 0 0 0 0]", k, transition ? "fixedValue" : "kqRWallFunction", transition ? 1e-12 : k);
  carried("omega", "[0 0 -1 0 0 0 0]", omega, "omegaWallFunction", omega);
  if (transition) {
    // Langtry and Menter (2009): intermittency 1 in the wind, and their correlation of the momentum thickness Reynolds number at transition
    // with the turbulence intensity in %, without pressure gradient.
    const double percent = 100.0 * numerics.turbulence_intensity;
    const double re_theta =
        percent <= 1.3 ? 1173.51 - 589.428 * percent + 0.2196 / (percent * percent) : 331.5 * std::pow(percent - 0.5658, -0.671);
    carried("gammaInt", "[0 0 0 0 0 0 0]", 1.0, "zeroGradient", 1.0);
    carried("ReThetat", "[0 0 0 0 0 0 0]", re_theta, "zeroGradient", re_theta);
  }
  const std::map<std::string, std::string> walls{
      {"spalding", "nutUSpaldingWallFunction"}, {"log_law", "nutkWallFunction"}, {"low_re", "nutLowReWallFunction"}};
  files["0/nut"] = field("nut", "volScalarField", "[0 2 -1 0 0 0 0]", fmt::format("{}", nut),
                         {"type calculated; value uniform 0;", "type calculated; value uniform 0;", "type calculated; value uniform 0;"},
                         boxed, "type " + walls.at(numerics.wall) + "; value uniform 0;", symmetry);
  return files;
}

std::string decomposition(int ranks) {
  return header("dictionary", "decomposeParDict") +
         fmt::format("numberOfSubdomains {0};\nmethod hierarchical;\nhierarchicalCoeffs {{ n ({0} 1 1); delta 0.001; order xyz; }}\n",
                     ranks);
}

}  // namespace cfd_cases
