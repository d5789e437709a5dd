#pragma once

#include <optional>
#include <string>

#include "cfd_cases/flow_case/matrix.hpp"
#include "cfd_cases/mesh/mesh_recipe.hpp"
#include "cfd_cases/programs/tools.hpp"

namespace cfd_cases {

/// Under which name a case and its mesh are stored. Both keys are the SHA-256 of a canonical description (JSON, sorted, shortest numbers)
/// of all that determines the result: shape, pose, Reynolds number, flow model, mesh recipe and level, generated dictionaries, stop policy,
/// tool versions. What does not (ranks, host, paths, time-out, tier, held_out, name) is left out.
struct CaseIdentity {
  Symmetry symmetry = Symmetry::none;
  Eigen::Matrix3d to_wind = Eigen::Matrix3d::Identity();  ///< from the frame of the mesh
  MeshRecipe recipe;
  std::string mesh_description, mesh_key;  ///< several flows may share a mesh
  std::string description, key;
  std::string start_key;  ///< of the case it starts from; empty: from uniform flow
};
CaseIdentity identify(const CaseSpec& spec, const Tools& tools);

/// The case that a stored description tells of, as far as it decides mesh, method and limits: what only enters as the digest of the
/// dictionaries (numerics), and name and tier, keep their defaults. Empty when the text is no description of identify(), and for
/// bodies given by triangles.
struct DescribedCase {
  CaseSpec spec;
  CaseIdentity identity;
};
std::optional<DescribedCase> described_case(const std::string& description);

/// Factors of all cell sizes that are tried one after the other until checkMesh accepts the mesh.
inline constexpr double kSizeFactors[] = {1.0, 0.97, 0.94};

std::string sha256(const std::string& text);  ///< hexadecimal

}  // namespace cfd_cases
