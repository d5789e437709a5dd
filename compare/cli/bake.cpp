#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <dragcore/baked_file.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <random>

#include "compare/cli/body.hpp"
#include "compare/cli/commands.hpp"

namespace cli {
namespace {

namespace fs = std::filesystem;

struct BakeCommand {
  BodyOptions body;
  ModelOptions model;
  std::string error = "1%", output;
  std::size_t most_kib = 64;
};

/// Of a C name: what letters, digits and underscores the file's name has.
std::string c_name(const fs::path& file) {
  std::string name = file.stem().string();
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return std::isdigit(static_cast<unsigned char>(name.front())) ? "body_" + name : name;
}

/// Of one call, best of nine runs over random motions [ns].
double nanoseconds(const dragcore::BakedBody& body, bool spins) {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  const auto random = [&] { return Eigen::Vector3d(normal(engine), normal(engine), normal(engine)); };
  std::vector<dragcore::Motion> motions(1000);
  for (dragcore::Motion& motion : motions) {
    motion.wind = random();
    if (spins) motion.angular_velocity = random() / body.length;
    motion.reference_point = body.centre;
  }
  std::vector<dragcore::Wrench> results(motions.size());
  double best = 1e300;
  for (int run = 0; run < 9; ++run) {
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < 20; ++k) dragcore::wrenches(body, motions, {}, results);
    const double all = std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
    best = std::min(best, all / (20.0 * static_cast<double>(motions.size())));
  }
  return best;
}

void print(const BakeCommand& options, const Body& body, const dragcore::BakedBody& baked) {
  const auto percent = [](double share) { return fmt::format("{:.2f} %", 100.0 * share); };
  const auto errors = [&](const std::string& motion, const dragcore::BakeError& e) {
    fmt::print("  {:<16} force {} rms, {} worst; torque {} rms, {} worst\n", motion, percent(e.rms_force), percent(e.worst_force),
               percent(e.rms_torque), percent(e.worst_torque));
  };
  fmt::print("{}: {} triangles, {}\n", options.body.file, body.surface.size(), options.model.label());
  fmt::print("  {:<16} {:.1f} KiB, {} triangles on each face of the octahedron\n", "map", static_cast<double>(baked.bytes()) / 1024.0,
             baked.steady.frequency * baked.steady.frequency);
  errors("no spin", baked.error);
  for (std::size_t k = 0; k < baked.spin_ratios.size(); ++k)
    errors(fmt::format("spin ratio {:g}", baked.spin_ratios[k]), baked.spin_error[k]);
  fmt::print("  {:<16} {:.1f} ns each in a batch, {:.1f} ns with spin\n", "time", nanoseconds(baked, false), nanoseconds(baked, true));
  fmt::print(
      "Errors of force are shares of its rms over the directions, those of torque of that times {} m. Spin ratio: spin times that, over "
      "speed.\n",
      text(baked.length));
}

}  // namespace

void add_bake(CLI::App& app, Context&) {
  const auto options = std::make_shared<BakeCommand>();
  CLI::App* command =
      app.add_subcommand("bake", "Force and torque of a body over direction as a small map, which costs the same for any mesh");
  command->footer(
      "A map replaces the mesh in a game: docs/baking.md. A .h5 file is for dragcore::read_baked(), a .h file for any C program.\n"
      "Example: dragval bake body.stl --unit mm --error 1% --output body.h");
  add_body_options(*command, options->body);
  add_model_options(*command, options->model);
  command->add_option("--error", options->error, "Wanted rms error of force and torque without spin")->capture_default_str();
  command->add_option("--size", options->most_kib, "Largest size of the map [KiB]")->check(CLI::Range(1, 1 << 20))->capture_default_str();
  command->add_option("--output", options->output, "File to write: .h5, or .h for a C header");
  command->callback([options] {
    const fs::path output = options->output;
    if (!output.empty() && output.extension() != ".h5" && output.extension() != ".h")
      throw UsageError(fmt::format("--output {}: the name must end in .h5 or .h", options->output));
    if (const fs::path folder = output.parent_path(); !folder.empty() && !fs::is_directory(folder))
      throw EnvironmentError(fmt::format("--output {}: there is no folder {}", options->output, folder.string()));
    const double wanted = share_from("--error", options->error);
    const Body body = load_body(options->body);
    dragcore::BakedBody baked;
    try {
      dragcore::Model model = options->model.model().on(body.surface);
      model.precision = dragcore::Precision::single;  // its error is no thousandth of the map's
      baked = bake(body.surface, model, {.rms_error = wanted, .most_bytes = options->most_kib * 1024});
    } catch (const std::invalid_argument& fault) {
      throw UsageError(std::string(fault.what()) + " (--error, --size)");
    }
    print(*options, body, baked);
    if (const std::string question = unit_question(options->body, body); !question.empty()) std::cerr << "dragval: " << question << "\n";
    if (output.empty()) return;
    if (output.extension() == ".h")
      write_c_header(output, baked, c_name(output));
    else
      write_baked(output, baked);
    std::cerr << "wrote " << options->output << "\n";
  });
}

}  // namespace cli
