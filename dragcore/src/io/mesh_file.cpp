#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>

#include "io/mesh_readers.hpp"
#include "io/text.hpp"

namespace dragcore {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& fault) {
  throw std::runtime_error("mesh file " + file.string() + ": " + fault);
}

}  // namespace

MeshFile read_mesh_file(const std::filesystem::path& file, double unit_m) {
  if (!(unit_m > 0.0) || !std::isfinite(unit_m))
    throw std::invalid_argument("read_mesh: unit_m = " + std::to_string(unit_m) + ", but it must be greater than 0");
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  try {
    const std::string bytes = bytes_of(file);
    if (extension != ".stl" && extension != ".obj")
      throw std::runtime_error("unknown kind " + in_quotes(extension) + "; needed: .stl or .obj");
    if (bytes.empty()) throw std::runtime_error("is empty");
    MeshFile result = extension == ".stl" ? read_stl(bytes) : read_obj(bytes);
    if (result.mesh.triangles.empty()) throw std::runtime_error("holds no triangle");
    for (Eigen::Vector3d& vertex : result.mesh.vertices) vertex *= unit_m;
    validate(result.mesh);
    result.mesh = welded(result.mesh);
    return result;
  } catch (const std::runtime_error& fault) {
    fail(file, fault.what());
  } catch (const std::invalid_argument& fault) {
    fail(file, fault.what());
  }
}

TriangleMesh read_mesh(const std::filesystem::path& file, double unit_m) { return read_mesh_file(file, unit_m).mesh; }

void write_stl(const std::filesystem::path& file, const TriangleMesh& mesh) {
  validate(mesh);
  std::ofstream out(file, std::ios::binary);
  char header[80] = "binary STL, metres";
  out.write(header, sizeof header);
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  out.write(reinterpret_cast<const char*>(&count), sizeof count);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Eigen::Vector3f n = (b - a).cross(c - a).normalized().cast<float>();
    for (const Eigen::Vector3f& v :
         {n, Eigen::Vector3f(a.cast<float>()), Eigen::Vector3f(b.cast<float>()), Eigen::Vector3f(c.cast<float>())})
      out.write(reinterpret_cast<const char*>(v.data()), 3 * sizeof(float));
    const std::uint16_t attribute = 0;
    out.write(reinterpret_cast<const char*>(&attribute), sizeof attribute);
  }
  if (!out.flush()) fail(file, "cannot be written; check the folder and the free space");
}

}  // namespace dragcore
