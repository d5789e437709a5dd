#include "cfd_cases/dictionaries.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace cfd_cases {

namespace {

std::string header(const std::string& type, const std::string& name) {
  return fmt::format("FoamFile {{ version 2.0; format ascii; class {}; object {}; }}\n", type, name);
}

std::string control(int iterations) {
  return header("dictionary", "controlDict") + fmt::format(R"foam(
application simpleFoam;
startFrom startTime;  startTime 0;
stopAt endTime;       endTime {0};
deltaT 1;
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
                                                           iterations, kDensity);
}

std::string schemes(const Numerics& n) {
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
  div((nuEff*dev2(T(grad(U))))) Gauss linear;
}}
laplacianSchemes {{ default Gauss linear corrected; }}
interpolationSchemes {{ default linear; }}
snGradSchemes {{ default corrected; }}
wallDist {{ method meshWave; }}
)foam",
                                                         gradient, convection);
}

std::string solution(const Numerics& n) {
  return header("dictionary", "fvSolution") + fmt::format(R"foam(
solvers
{{
  p {{ solver GAMG; smoother GaussSeidel; tolerance 1e-8; relTol 0.05; }}
  "(U|k|omega)" {{ solver PBiCGStab; preconditioner DILU; tolerance 1e-9; relTol 0.1; }}
}}
SIMPLE {{ consistent yes; nNonOrthogonalCorrectors 0; }}
relaxationFactors
{{
  fields {{ p {0}; }}
  equations {{ U {1}; "(k|omega)" {2}; }}
}}
)foam",
                                                          n.relaxation_pressure, n.relaxation_velocity, n.relaxation_turbulence);
}

/// A boundary field; the slip sides and the symmetry plane are the same for all.
std::string field(const std::string& name, const std::string& type, const std::string& dimensions, const std::string& initial,
                  const std::string& inlet, const std::string& outlet, const std::string& body, Symmetry symmetry) {
  return header(type, name) + fmt::format("dimensions {};\ninternalField uniform {};\nboundaryField\n{{\n", dimensions, initial) +
         fmt::format("  inlet {{ {} }}\n  outlet {{ {} }}\n  sides {{ type slip; }}\n  body {{ {} }}\n", inlet, outlet, body) +
         (symmetry == Symmetry::none ? "" : "  symmetry { type symmetry; }\n") + "}\n";
}

}  // namespace

double kinematic_viscosity(const CaseSpec& spec) { return kSpeed * dragcore::properties(spec.shape).reference_length / spec.reynolds; }

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
  const bool laminar = spec.flow_model == "laminar";
  std::map<std::string, std::string> files;
  files["system/controlDict"] = control(spec.stop.max_iterations * (rung == Rung::cautious ? 2 : 1));
  files["system/fvSchemes"] = schemes(numerics);
  files["system/fvSolution"] = solution(numerics);
  files["constant/transportProperties"] =
      header("dictionary", "transportProperties") + fmt::format("transportModel Newtonian;\nnu {};\n", nu);
  files["constant/turbulenceProperties"] =
      header("dictionary", "turbulenceProperties") +
      (laminar ? "simulationType laminar;\n" : "simulationType RAS;\nRAS { RASModel kOmegaSST; turbulence on; printCoeffs off; }\n");

  const std::string wind = fmt::format("({} 0 0)", kSpeed);
  // inletOutlet: eddies that reach the outlet may draw air back in, at rest.
  files["0/U"] = field("U", "volVectorField", "[0 1 -1 0 0 0 0]", wind, "type fixedValue; value uniform " + wind + ";",
                       "type inletOutlet; inletValue uniform (0 0 0); value uniform " + wind + ";", "type noSlip;", symmetry);
  files["0/p"] = field("p", "volScalarField", "[0 2 -2 0 0 0 0]", "0", "type zeroGradient;", "type fixedValue; value uniform 0;",
                       "type zeroGradient;", symmetry);
  if (laminar) return files;

  const double k = 1.5 * numerics.turbulence_intensity * numerics.turbulence_intensity * kSpeed * kSpeed;
  const double nut = numerics.viscosity_ratio * nu, omega = k / nut;
  const auto carried = [&](const char* name, const char* dimensions, double value, const char* wall) {
    files[std::string("0/") + name] =
        field(name, "volScalarField", dimensions, fmt::format("{}", value), fmt::format("type fixedValue; value uniform {};", value),
              fmt::format("type inletOutlet; inletValue uniform {0}; value uniform {0};", value),
              fmt::format("type {}; value uniform {};", wall, value), symmetry);
  };
  carried("k", "[0 2 -2 0 0 0 0]", k, "kqRWallFunction");
  carried("omega", "[0 0 -1 0 0 0 0]", omega, "omegaWallFunction");
  files["0/nut"] = field("nut", "volScalarField", "[0 2 -1 0 0 0 0]", fmt::format("{}", nut), "type calculated; value uniform 0;",
                         "type calculated; value uniform 0;", "type nutUSpaldingWallFunction; value uniform 0;", symmetry);
  return files;
}

std::string decomposition(int ranks) {
  return header("dictionary", "decomposeParDict") +
         fmt::format("numberOfSubdomains {0};\nmethod hierarchical;\nhierarchicalCoeffs {{ n ({0} 1 1); delta 0.001; order xyz; }}\n",
                     ranks);
}

}  // namespace cfd_cases
