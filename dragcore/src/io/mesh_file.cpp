#include <dragcore/mesh_file.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace dragcore {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& fault) { throw std::runtime_error("mesh file " + file.string() + ": " + fault); }

/// An ascii STL file ends with "endsolid"; the importer takes a half file for a whole one.
void check_ascii_end(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = in.tellg();
  in.seekg(std::max<std::streamoff>(0, size - 200));  // the word, a name and blank lines
  const std::string tail{std::istreambuf_iterator<char>(in), {}};
  if (tail.find("endsolid") == std::string::npos) fail(file, "truncated: an ascii STL file ends with 'endsolid'. Export it again");
}

/// A binary STL file states its number of triangles, 50 bytes each behind 84 of header; the importer would read past a lie.
void check_stl(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  char header[84];
  if (!in.read(header, sizeof header)) {
    if (in.gcount() >= 5 && std::strncmp(header, "solid", 5) == 0) return check_ascii_end(file);
    fail(file, "only " + std::to_string(in.gcount()) + " bytes; a binary STL file has at least 84. Export it again");
  }
  std::uint32_t count = 0;
  std::memcpy(&count, header + 80, sizeof count);
  const std::uintmax_t size = std::filesystem::file_size(file), needed = 84 + 50 * std::uintmax_t{count};
  if (size == needed) return;
  if (std::strncmp(header, "solid", 5) == 0) {
    std::ifstream text(file);
    std::string word;
    for (int i = 0; i < 400 && text >> word; ++i)
      if (word == "facet" || word == "endsolid") return check_ascii_end(file);
  }
  fail(file, "truncated or damaged: its header promises " + std::to_string(count) + " triangles, " + std::to_string(needed) + " bytes, but it has " +
                 std::to_string(size) + ". Export it again");
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& file, double unit_m) {
  if (!(unit_m > 0.0) || !std::isfinite(unit_m)) throw std::invalid_argument("read_mesh: unit_m = " + std::to_string(unit_m) + ", but it must be greater than 0");
  if (!std::filesystem::is_regular_file(file)) fail(file, "no such file");
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".stl" && extension != ".obj") fail(file, "unknown kind '" + extension + "'; needed: .stl or .obj");
  if (extension == ".stl") check_stl(file);

  Assimp::Importer importer;
  // Positions and faces are all that is asked for; points and lines are dropped.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_SortByPType);
  if (!scene) fail(file, "not readable: " + std::string(importer.GetErrorString()).substr(0, 200));  // it may quote the rest of the file

  TriangleMesh mesh;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const int first = static_cast<int>(mesh.vertices.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v)
      mesh.vertices.push_back(unit_m * Eigen::Vector3d(part.mVertices[v].x, part.mVertices[v].y, part.mVertices[v].z));
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;
      mesh.triangles.emplace_back(first + static_cast<int>(face.mIndices[0]), first + static_cast<int>(face.mIndices[1]), first + static_cast<int>(face.mIndices[2]));
    }
  }
  if (mesh.triangles.empty()) fail(file, "holds no triangle");
  try {
    validate(mesh);
  } catch (const std::invalid_argument& fault) {
    fail(file, fault.what());
  }
  return welded(mesh);
}

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
    for (const Eigen::Vector3f& v : {n, Eigen::Vector3f(a.cast<float>()), Eigen::Vector3f(b.cast<float>()), Eigen::Vector3f(c.cast<float>())})
      out.write(reinterpret_cast<const char*>(v.data()), 3 * sizeof(float));
    const std::uint16_t attribute = 0;
    out.write(reinterpret_cast<const char*>(&attribute), sizeof attribute);
  }
  if (!out.flush()) fail(file, "cannot be written; check the folder and the free space");
}

}  // namespace dragcore
