#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <dragcore/drag.hpp>
#include <dragcore/mesh_file.hpp>
#include <memory>

#include "compare/cli/commands.hpp"

namespace cli {

void add_mesh(CLI::App& app, Context&) {
  struct Options {
    std::string file;
    double unit_m = 1.0;
    bool sheet = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("mesh", "Says what an STL or OBJ file is, and whether its drag can be computed");
  command->footer("Example: dragval mesh body.stl --unit 0.001");
  command->add_option("file", options->file, "STL (ascii or binary) or OBJ")->required();
  command->add_option("--unit", options->unit_m, "Size of the file's unit [m]")->capture_default_str();
  command->add_flag("--sheet", options->sheet, "Both sides of every triangle feel the air, as they do anyway where the mesh is open");
  command->callback([options] {
    const dragcore::TriangleMesh mesh = dragcore::read_mesh(options->file, options->unit_m);
    fmt::print("{}: {}\n", options->file, describe(dragcore::inspect(mesh)));
    const dragcore::Surface surface(mesh, options->sheet ? dragcore::Surface::Sides::two : dragcore::Surface::Sides::automatic);
    fmt::print("{} triangles feel the air on {}, in {} planar patches\n", surface.size(),
               surface.two_sided() ? "both sides" : "their outer side", surface.patches.size());
  });
}

}  // namespace cli
