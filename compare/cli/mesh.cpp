#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <dragcore/mesh_file.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "compare/cli/body.hpp"
#include "compare/cli/commands.hpp"

namespace cli {
namespace {

nlohmann::json to_json(const BodyOptions& options, const Body& body, const dragcore::Model& advised) {
  const auto vector = [](const Eigen::Vector3d& v) { return nlohmann::json{v.x(), v.y(), v.z()}; };
  const dragcore::MeshProperties& p = body.properties;
  nlohmann::json result = {{"file", options.file},
                           {"unit_m", options.unit_m()},
                           {"triangles_of_file", body.triangles_of_file},
                           {"triangles", p.triangles},
                           {"extents_m", vector(body.extents())},
                           {"class", to_string(body.surface.body_class)},
                           {"two_sided", body.surface.two_sided()},
                           {"closed", p.closed},
                           {"law", advised.law.name},
                           {"pillow", to_string(advised.pillow.form)},
                           {"pillow_factor", advised.pillow.factor},
                           {"centroid_m", vector(p.centroid)},
                           {"area_m2", p.area},
                           {"volume_m3", p.encloses ? nlohmann::json(p.volume) : nlohmann::json(nullptr)},
                           {"hole_area_m2", p.hole_area},
                           {"parts", body.surface.parts.size()},
                           {"convex", body.surface.convex},
                           {"windward_over_silhouette", body.windward_ratio},
                           {"silhouette_m2", body.silhouette},
                           {"forces_volume_m3", body.surface.volume},
                           {"forces_area_m2", body.surface.total_area},
                           {"notes", body.notes},
                           {"findings", body.findings}};
  const std::string question = unit_question(options, body);
  result["question"] = question.empty() ? nlohmann::json(nullptr) : nlohmann::json(question);
  return result;
}

void print(const BodyOptions& options, const Body& body, const dragcore::Model& advised) {
  const auto line = [](const char* name, const std::string& text) { fmt::print("  {:<9} {}\n", name, text); };
  const Eigen::Vector3d size = body.extents(), at = body.properties.centroid;
  fmt::print("{}: {}\n", options.file, describe(body.properties));
  if (body.triangles_of_file != body.properties.triangles)
    line("file", fmt::format("{} triangles before preparation", body.triangles_of_file));
  line("extents", fmt::format("{:.4g} x {:.4g} x {:.4g} m", size.x(), size.y(), size.z()));
  line("centroid", fmt::format("{} {} {} m", text(at.x(), size.maxCoeff()), text(at.y(), size.maxCoeff()), text(at.z(), size.maxCoeff())));
  const char* sides = body.surface.two_sided()                                    ? "both sides"
                      : body.surface.sides == dragcore::Surface::Sides::automatic ? "both sides of sheets, the outer side of bodies"
                                                                                  : "the outer side";
  line("class",
       fmt::format("{}; {}; the air is felt on {}", to_string(body.surface.body_class),
                   body.surface.parts.size() == 1 ? std::string("one part") : fmt::format("{} parts", body.surface.parts.size()), sides));
  line("shape",
       body.surface.convex ? "convex: nothing stands in its own wind"
       : body.windward_ratio < 1.005
           ? std::string("not convex, but hardly anything stands in its own wind")
           : fmt::format("not convex: up to {:.3g} times the silhouette faces the wind; rays say what it reaches", body.windward_ratio));
  std::string law = fmt::format("{} with the {} pillow {:g}", advised.law.name, to_string(advised.pillow.form), advised.pillow.factor);
  if (advised.sheets)
    law += fmt::format("; {} with {:g} on parts that are sheets", advised.sheets->law.name, advised.sheets->pillow.factor);
  line("law", law + " is advised (--law class)");
  for (const std::string& note : body.notes) line("note", note);
  for (const std::string& finding : body.findings) line("found", finding);
  if (const std::string question = unit_question(options, body); !question.empty()) line("question", question);
}

}  // namespace

void add_mesh(CLI::App& app, Context&) {
  struct Options {
    BodyOptions body;
    std::string repair;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("mesh", "Says what an STL or OBJ file is, and whether its drag can be computed");
  command->footer("Example: dragval mesh body.stl --unit mm");
  add_body_options(*command, options->body);
  command->add_option("--repair", options->repair, "Write the mesh that the forces see to this STL file, in metres");
  command->add_flag("--json", options->json, "Print JSON");
  command->callback([options] {
    namespace fs = std::filesystem;
    if (std::error_code none; !options->repair.empty() && fs::equivalent(options->repair, options->body.file, none))
      throw UsageError("--repair would overwrite the file itself; give another name");
    if (!options->repair.empty() && fs::path(options->repair).extension() != ".stl")
      throw UsageError(fmt::format("--repair {}: the name must end in .stl, which is what is written", options->repair));
    const Body body = load_body(options->body);
    const dragcore::Model advised = model_for(body.surface);
    if (options->json)
      std::cout << to_json(options->body, body, advised).dump(2) << "\n";
    else
      print(options->body, body, advised);
    if (options->repair.empty()) return;
    dragcore::write_stl(options->repair, body.mesh);
    std::cerr << "wrote " << options->repair << ", " << body.mesh.triangles.size() << " triangles, in metres\n";
  });
}

}  // namespace cli
