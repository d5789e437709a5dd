#include "cfd_cases/flow_case/case_key.hpp"

#include <fmt/format.h>
#include <openssl/sha.h>

#include <array>
#include <nlohmann/json.hpp>

#include "cfd_cases/flow_case/dictionaries.hpp"
#include "cfd_cases/mesh/snappy.hpp"

namespace cfd_cases {

std::string sha256(const std::string& text) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
  std::string hexadecimal;
  for (const unsigned char byte : digest) hexadecimal += fmt::format("{:02x}", byte);
  return hexadecimal;
}

namespace {

std::string digest_of(const std::map<std::string, std::string>& files) {
  std::string together;
  for (const auto& [path, text] : files) together += path + "\n" + text;
  return sha256(together);
}

}  // namespace

CaseIdentity identify(const CaseSpec& spec, const Tools& tools) {
  CaseIdentity id;
  id.recipe = spec.recipe;
  id.recipe.refinement = refinement_of(spec.mesh_level, spec.octree());
  id.recipe.dual_feature_angle_deg = kept_feature_angle_deg(spec.shape, id.recipe.dual_feature_angle_deg);
  if (spec.mesh_in_body_frame()) id.to_wind = spec.pose.radians().rotation();
  if (spec.half_model) id.symmetry = find_symmetry(spec.shape, spec.pose.radians(), spec.spin.direction(), id.to_wind);
  const auto degrees = [](const PoseDegrees& pose) {
    return nlohmann::json{{"incidence_deg", pose.incidence}, {"yaw_deg", pose.yaw}, {"roll_deg", pose.roll}};
  };
  const nlohmann::json pose = degrees(spec.pose), mesh_pose = degrees(spec.mesh_pose());
  nlohmann::json mesh{{"shape", to_json(spec.shape)},       {"pose", mesh_pose},
                      {"symmetry", to_string(id.symmetry)}, {"recipe", to_json(id.recipe)},
                      {"size_factors", kSizeFactors},       {"tools", tools.versions()}};
  if (const auto* body = std::get_if<dragcore::MeshBody>(&spec.shape))
    mesh["snappy_sha256"] = digest_of(snappy_files(*body, spec.mesh_pose().radians(), id.recipe, id.symmetry));  // holds every triangle
  id.mesh_description = mesh.dump();
  id.mesh_key = sha256(id.mesh_description);

  std::string files;
  for (const Rung rung : {Rung::standard, Rung::cautious})
    for (const auto& [path, text] : dictionaries(spec, id.symmetry, rung)) files += path + "\n" + text;
  const StopPolicy& s = spec.stop;
  nlohmann::json description{{"schema", 1},
                             {"shape", to_json(spec.shape)},
                             {"pose", pose},
                             {"reynolds", spec.reynolds},
                             {"flow_model", spec.flow_model},
                             {"speed_m_s", kSpeed},
                             {"density_kg_m3", kDensity},
                             {"mesh_level", spec.mesh_level},
                             {"mesh", mesh},
                             {"dictionaries_sha256", sha256(files)},
                             {"stop",
                              {{"min_iterations", s.min_iterations},
                               {"max_iterations", s.max_iterations},
                               {"window", s.window},
                               {"average", s.average},
                               {"tolerance", s.tolerance},
                               {"floor", s.floor}}},
                             {"retries", spec.retries},
                             {"tools", tools.versions()}};
  // Only where they say something: what was solved before there was a choice keeps its key.
  if (!spec.spin.axis.empty()) description["spin"] = {{"axis", spec.spin.axis}, {"ratio", spec.spin.ratio}};
  if (spec.time_accurate())
    description["time"] = {{"step", spec.time.step}, {"duration", spec.time.duration}, {"discard", spec.time.discard}};
  if (s.mean_error != StopPolicy{}.mean_error) description["stop"]["mean_error"] = s.mean_error;
  if (spec.mesh_in_body_frame()) description["mesh_frame"] = "body";
  if (spec.start) description["start"] = id.start_key = identify(*spec.start, tools).key;
  id.description = description.dump();
  id.key = sha256(id.description);
  return id;
}

std::optional<DescribedCase> described_case(const std::string& description) {
  try {
    const auto text = nlohmann::json::parse(description);
    const auto &mesh = text.at("mesh"), &pose = text.at("pose"), &stop = text.at("stop");
    DescribedCase found;
    CaseSpec& spec = found.spec;
    if (text.at("shape").contains("triangles")) return std::nullopt;  // which are not in the description
    spec.shape = shape_from_json(text.at("shape"));
    spec.pose = {pose.at("incidence_deg"), pose.at("yaw_deg"), pose.at("roll_deg")};
    spec.reynolds = text.at("reynolds");
    spec.flow_model = text.at("flow_model");
    spec.mesh_level = text.at("mesh_level");
    spec.stop = {.min_iterations = stop.at("min_iterations"),
                 .max_iterations = stop.at("max_iterations"),
                 .window = stop.at("window"),
                 .average = stop.at("average"),
                 .tolerance = stop.at("tolerance"),
                 .floor = stop.at("floor"),
                 .mean_error = stop.value("mean_error", StopPolicy{}.mean_error)};
    spec.retries = text.at("retries");
    CaseIdentity& id = found.identity;
    id.symmetry = symmetry_from(mesh.at("symmetry"));
    id.recipe = recipe_from_json(mesh.at("recipe"));
    spec.recipe = id.recipe;
    spec.recipe.refinement = 1.0;
    spec.half_model = id.symmetry != Symmetry::none;
    if (const auto spin = text.find("spin"); spin != text.end()) spec.spin = {spin->at("axis"), spin->at("ratio")};
    if (const auto time = text.find("time"); time != text.end()) spec.time = {time->at("step"), time->at("duration"), time->at("discard")};
    spec.turn_wind = text.contains("mesh_frame");
    id.mesh_description = mesh.dump();
    id.mesh_key = sha256(id.mesh_description);
    id.description = description;
    id.key = sha256(description);
    return found;
  } catch (const nlohmann::json::exception&) {  // a wind tunnel's, for example
    return std::nullopt;
  }
}

}  // namespace cfd_cases
