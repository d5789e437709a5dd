#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <dragcore/mesh_file.hpp>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace dragcore {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& fault) {
  throw std::runtime_error("mesh file " + file.string() + ": " + fault);
}

/// The importer is given the bytes of one file and may open no other.
class NoOtherFile : public Assimp::IOSystem {
 public:
  bool Exists(const char*) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
  void Close(Assimp::IOStream*) override {}
};

/// An ascii STL file ends with "endsolid"; the importer takes a half file for a whole one.
void check_ascii_end(const std::filesystem::path& file, std::string_view bytes) {
  const std::string_view tail = bytes.substr(bytes.size() - std::min<std::size_t>(200, bytes.size()));  // the word, a name and blank lines
  if (tail.find("endsolid") == std::string_view::npos) fail(file, "truncated: an ascii STL file ends with 'endsolid'. Export it again");
}

/// A binary STL file states its number of triangles, 50 bytes each behind 84 of header; the importer would read past a lie.
void check_stl(const std::filesystem::path& file, std::string_view bytes) {
  constexpr std::size_t header = 84;
  if (bytes.size() < header) {
    if (bytes.starts_with("solid")) return check_ascii_end(file, bytes);
    fail(file, "only " + std::to_string(bytes.size()) + " bytes; a binary STL file has at least 84. Export it again");
  }
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  const std::uintmax_t needed = header + 50 * std::uintmax_t{count};
  if (bytes.size() == needed) return;
  if (bytes.starts_with("solid")) {
    std::istringstream text{std::string(bytes.substr(0, 10'000))};
    std::string word;
    while (text >> word)
      if (word == "facet" || word == "endsolid") return check_ascii_end(file, bytes);
  }
  fail(file, "truncated or damaged: its header promises " + std::to_string(count) + " triangles, " + std::to_string(needed) +
                 " bytes, but it has " + std::to_string(bytes.size()) + ". Export it again");
}

/// The words of a line, none of which goes on behind its end.
std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view space = " \t\r\v\f";
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(space); at != std::string_view::npos; at = line.find_first_not_of(space, at)) {
    const std::size_t end = std::min(line.find_first_of(space, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

/// A number that takes up a whole word, or nothing.
template <class Number>
std::optional<Number> number_of(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  Number value{};
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || stop != word.data() + word.size()) return std::nullopt;
  return value;
}

/// Splits a polygon into triangles by cutting off ears, convex corners whose triangle holds no other corner; a convex one becomes a fan
/// from its first corner. Where there is no ear, because edges cross or all lies on a line, the rest becomes a fan too.
void split(const std::vector<Eigen::Vector3d>& vertices, std::vector<int> corners, std::vector<Eigen::Vector3i>& triangles) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  const auto place = [&](int corner) -> const Eigen::Vector3d& { return vertices[static_cast<std::size_t>(corner)]; };
  const auto arm = [&](std::size_t i) { return Eigen::Vector3d(place(corners[i]) - place(corners[0])); };
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) normal += arm(i).cross(arm(i + 1));
  // Seen along the axis that is nearest to the normal, from the side where the corners run counterclockwise.
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  Eigen::Index x = (axis + 1) % 3, y = (axis + 2) % 3;
  if (normal[axis] < 0.0) std::swap(x, y);
  const auto turn = [&](int from, int at, int to) {  // twice the area of the three, positive where they turn left
    const Eigen::Vector3d &a = place(from), &b = place(at), &c = place(to);
    return (b[x] - a[x]) * (c[y] - a[y]) - (b[y] - a[y]) * (c[x] - a[x]);
  };
  std::vector<int> hollow;  // corners that are not convex: only they can lie in an ear
  while (corners.size() > 3) {
    const std::size_t n = corners.size();
    const auto corner = [&](std::size_t i) { return corners[i % n]; };
    hollow.clear();
    for (std::size_t i = 0; i < n; ++i)
      if (!(turn(corner(i + n - 1), corner(i), corner(i + 1)) > 0.0)) hollow.push_back(corner(i));
    std::size_t ear = n;
    for (std::size_t i = 1; i <= n && ear == n; ++i) {
      const int before = corner(i - 1), at = corner(i), after = corner(i + 1);
      if (!(turn(before, at, after) > 0.0)) continue;
      const bool blocked = std::any_of(hollow.begin(), hollow.end(), [&](int other) {
        if (place(other) == place(before) || place(other) == place(at) || place(other) == place(after)) return false;
        return turn(before, at, other) >= 0.0 && turn(at, after, other) >= 0.0 && turn(after, before, other) >= 0.0;
      });
      if (!blocked) ear = i % n;
    }
    if (ear == n) break;
    triangles.emplace_back(corner(ear + n - 1), corner(ear), corner(ear + 1));
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) triangles.emplace_back(corners[0], corners[i], corners[i + 1]);
}

/// Vertices and faces of an OBJ file; all else in it is of no account. Not left to assimp 5.2: it opens whatever file an OBJ file names,
/// can write outside of its memory when given the bytes instead (tests/fuzz/corpus/obj), and covers an L with more than its area.
TriangleMesh read_obj(const std::filesystem::path& file, std::string_view bytes) {
  // The time that cutting ears takes grows with the square of the corners, with their cube at worst.
  constexpr std::size_t most_corners = 2000;
  struct Face {
    std::size_t line;
    std::vector<int> corners;
  };
  TriangleMesh mesh;
  std::vector<Face> faces;
  std::size_t line_number = 0;
  while (!bytes.empty()) {
    // A line that ends with a backslash goes on in the next.
    std::string line;
    const std::size_t first_line = line_number + 1;
    for (bool goes_on = true; goes_on && !bytes.empty();) {
      const std::size_t end = std::min(bytes.find('\n'), bytes.size());
      line += bytes.substr(0, end);
      bytes.remove_prefix(std::min(end + 1, bytes.size()));
      ++line_number;
      while (!line.empty() && line.back() == '\r') line.pop_back();
      goes_on = !line.empty() && line.back() == '\\';
      if (goes_on) line.back() = ' ';
    }
    const auto wrong = [&](const std::string& fault) { fail(file, "line " + std::to_string(first_line) + ": " + fault); };
    const auto quote = [](std::string_view word) { return std::string("'").append(word.substr(0, 40)).append("'"); };
    const std::vector<std::string_view> words = words_of(line);
    if (words.empty()) continue;
    const auto count = static_cast<long long>(mesh.vertices.size());
    if (words[0] == "v") {
      if (words.size() < 4) wrong("a vertex has " + std::to_string(words.size() - 1) + " coordinates; needed: three");
      // A fourth number alone is a weight; six or more end with a colour.
      std::array<double, 4> place{0.0, 0.0, 0.0, 1.0};
      for (std::size_t i = 0; i < (words.size() == 5 ? 4u : 3u); ++i) {
        const std::optional<double> value = number_of<double>(words[i + 1]);
        if (!value || !std::isfinite(*value)) wrong("a coordinate of a vertex is " + quote(words[i + 1]) + "; needed: a finite number");
        place[i] = *value;
      }
      if (place[3] == 0.0) wrong("the weight of a vertex is 0, which puts it at infinity; needed: another number");
      mesh.vertices.push_back(Eigen::Vector3d(place[0], place[1], place[2]) / place[3]);
    } else if (words[0] == "f") {
      if (words.size() < 4) continue;  // a point or a line
      if (words.size() > most_corners + 1)
        wrong("a face has " + std::to_string(words.size() - 1) + " corners; needed: no more than " + std::to_string(most_corners) +
              ". Split it into triangles");
      Face face{first_line, {}};
      for (std::size_t i = 1; i < words.size(); ++i) {
        const std::optional<int> given = number_of<int>(words[i].substr(0, words[i].find('/')));
        if (!given) wrong("a corner of a face is " + quote(words[i]) + "; needed: the number of a vertex");
        const long long index = *given < 0 ? count + *given : *given - 1LL;  // negative ones count back from the last vertex so far
        if (index < 0) wrong("a face refers to vertex " + std::to_string(*given) + ", of " + std::to_string(count) + " so far");
        face.corners.push_back(static_cast<int>(index));
      }
      faces.push_back(std::move(face));
    }
  }
  for (Face& face : faces) {
    const int largest = *std::max_element(face.corners.begin(), face.corners.end());
    if (static_cast<std::size_t>(largest) >= mesh.vertices.size())
      fail(file, "line " + std::to_string(face.line) + ": a face refers to vertex " + std::to_string(largest + 1LL) + ", but there are " +
                     std::to_string(mesh.vertices.size()));
    split(mesh.vertices, std::move(face.corners), mesh.triangles);
  }
  return mesh;
}

/// Triangles of an STL file that check_stl() has passed.
TriangleMesh read_stl(const std::filesystem::path& file, std::string_view bytes) {
  Assimp::Importer importer;
  importer.SetIOHandler(new NoOtherFile);  // which the importer deletes
  // Positions and faces are all that is asked for; points and lines are dropped.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate | aiProcess_SortByPType, "stl");
  if (!scene) fail(file, "not readable: " + std::string(importer.GetErrorString()).substr(0, 200));  // it may quote the rest of the file
  TriangleMesh mesh;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const int first = static_cast<int>(mesh.vertices.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v)
      mesh.vertices.emplace_back(part.mVertices[v].x, part.mVertices[v].y, part.mVertices[v].z);
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;
      const auto corner = [&](int k) { return first + static_cast<int>(face.mIndices[k]); };
      mesh.triangles.emplace_back(corner(0), corner(1), corner(2));
    }
  }
  return mesh;
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& file, double unit_m) {
  if (!(unit_m > 0.0) || !std::isfinite(unit_m))
    throw std::invalid_argument("read_mesh: unit_m = " + std::to_string(unit_m) + ", but it must be greater than 0");
  if (!std::filesystem::is_regular_file(file)) fail(file, "no such file");
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".stl" && extension != ".obj") fail(file, "unknown kind '" + extension + "'; needed: .stl or .obj");
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (!in || in.bad()) fail(file, "cannot be read");
  if (bytes.empty()) fail(file, "is empty");
  if (extension == ".stl") check_stl(file, bytes);

  TriangleMesh mesh = extension == ".stl" ? read_stl(file, bytes) : read_obj(file, bytes);
  if (mesh.triangles.empty()) fail(file, "holds no triangle");
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= unit_m;
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
    for (const Eigen::Vector3f& v :
         {n, Eigen::Vector3f(a.cast<float>()), Eigen::Vector3f(b.cast<float>()), Eigen::Vector3f(c.cast<float>())})
      out.write(reinterpret_cast<const char*>(v.data()), 3 * sizeof(float));
    const std::uint16_t attribute = 0;
    out.write(reinterpret_cast<const char*>(&attribute), sizeof attribute);
  }
  if (!out.flush()) fail(file, "cannot be written; check the folder and the free space");
}

}  // namespace dragcore
