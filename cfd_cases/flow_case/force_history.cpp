#include "cfd_cases/flow_case/force_history.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "cfd_cases/flow_case/case_mesh.hpp"

namespace cfd_cases {

namespace fs = std::filesystem;
using Eigen::Vector3d;

namespace {

struct Row {
  double time;
  Vector3d pressure, viscous;
};

std::vector<Row> parse_rows(std::string_view text, const char* what) {
  std::vector<Row> rows;
  bool header_seen = false;
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string_view::npos; begin = end + 1) {
    const std::string_view line = text.substr(begin, end - begin);
    if (line.starts_with('#')) {
      const auto total = line.find("total_x"), pressure = line.find("pressure_x"), viscous = line.find("viscous_x");
      header_seen = header_seen || (viscous != line.npos && total < pressure && pressure < viscous);
      continue;
    }
    if (!header_seen)
      throw std::runtime_error(fmt::format("{}: no header with the columns total, pressure, viscous before the first row", what));
    std::array<double, 10> value{};
    std::size_t n = 0;
    const char* const stop = line.data() + line.size();
    for (const char* at = line.data(); at < stop;) {
      if (std::string_view(" \t()").find(*at) != std::string_view::npos) {
        ++at;
        continue;
      }
      double number = 0.0;
      const auto [rest, error] = std::from_chars(at, stop, number);
      if (error != std::errc{} || n == value.size())
        throw std::runtime_error(fmt::format("{}: '{}' is not a row of ten numbers", what, line));
      value[n++] = number;
      at = rest;
    }
    if (n != value.size()) throw std::runtime_error(fmt::format("{}: '{}' has {} numbers, needed 10", what, line, n));
    const Vector3d total(value[1], value[2], value[3]);
    const Row row{value[0], {value[4], value[5], value[6]}, {value[7], value[8], value[9]}};
    // 1e-6: the file has ten digits; a sum that cancels five of them still passes. Rows that are not finite are left to the detector of
    // divergence.
    const double size = std::max(row.pressure.norm(), row.viscous.norm());
    if ((total - row.pressure - row.viscous).norm() > 1e-6 * size)
      throw std::runtime_error(fmt::format("{}: at time {} total is not pressure + viscous", what, row.time));
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

std::vector<ForceSample> parse_forces(std::string_view force, std::string_view moment) {
  const std::vector<Row> forces = parse_rows(force, "force.dat"), moments = parse_rows(moment, "moment.dat");
  std::vector<ForceSample> samples;
  for (std::size_t i = 0; i < std::min(forces.size(), moments.size()); ++i) {
    if (forces[i].time != moments[i].time)
      throw std::runtime_error(
          fmt::format("force.dat and moment.dat differ: row {} is of time {} and {}", i, forces[i].time, moments[i].time));
    samples.push_back({forces[i].time, {forces[i].pressure, forces[i].viscous, moments[i].pressure, moments[i].viscous}});
  }
  return samples;
}

std::vector<ForceSample> read_forces(const fs::path& case_folder) {
  const fs::path root = case_folder / "postProcessing/forces";
  std::vector<std::pair<double, fs::path>> starts;
  if (fs::exists(root))
    for (const auto& entry : fs::directory_iterator(root)) starts.emplace_back(std::stod(entry.path().filename().string()), entry.path());
  std::sort(starts.begin(), starts.end());
  std::vector<ForceSample> all;
  for (const auto& [start, folder] : starts) {
    try {
      const auto part = parse_forces(contents(folder / "force.dat"), contents(folder / "moment.dat"));
      if (part.empty()) continue;
      while (!all.empty() && all.back().time >= part.front().time) all.pop_back();
      all.insert(all.end(), part.begin(), part.end());
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(fmt::format("{}: {}", folder.string(), error.what()));
    }
  }
  return all;
}

case_record::Load whole_body(const case_record::Load& meshed, Symmetry symmetry) {
  if (symmetry == Symmetry::none) return meshed;
  const int across = symmetry == Symmetry::plane_y ? 1 : 2;
  // A force is a vector, a moment an axial vector: mirrored halves add where the one keeps its sign and cancel where it does not.
  Vector3d force = Vector3d::Constant(2.0), moment = Vector3d::Zero();
  force[across] = 0.0;
  moment[across] = 2.0;
  return {meshed.force_pressure.cwiseProduct(force), meshed.force_viscous.cwiseProduct(force), meshed.moment_pressure.cwiseProduct(moment),
          meshed.moment_viscous.cwiseProduct(moment)};
}

}  // namespace cfd_cases
