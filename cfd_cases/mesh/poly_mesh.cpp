#include "cfd_cases/mesh/poly_mesh.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>

namespace cfd_cases {

using Eigen::Vector3d;
namespace fs = std::filesystem;

namespace {

/// A cursor over OpenFOAM's ascii syntax: numbers, words and brackets, with comments and the header skipped.
class Scanner {
 public:
  explicit Scanner(const fs::path& file) : file_(file.string()) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw std::runtime_error(fmt::format("cannot read {}: the mesh or the solver's output is incomplete", file_));
    std::ostringstream all;
    all << in.rdbuf();
    text_ = std::move(all).str();
    if (const auto header = text_.find("FoamFile"); header != std::string::npos) {
      if (text_.find("binary", header) < text_.find('}', header)) fail("is binary; needed writeFormat ascii");
      at_ = text_.find('}', header) + 1;
    }
  }

  [[noreturn]] void fail(const std::string& what) const { throw std::runtime_error(fmt::format("{}: {}", file_, what)); }

  char peek() {
    for (;;) {
      while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
      if (text_.compare(at_, 2, "//") == 0)
        at_ = std::min(text_.size(), text_.find('\n', at_));
      else if (text_.compare(at_, 2, "/*") == 0)
        at_ = std::min(text_.size(), text_.find("*/", at_) + 2);
      else
        break;
    }
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  void expect(char needed) {
    if (const char found = peek(); found != needed)
      fail(fmt::format("truncated or malformed at byte {}: found '{}', needed '{}'", at_, found, needed));
    ++at_;
  }
  template <class Number>
  Number number() {
    peek();
    Number value{};
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc{}) fail(fmt::format("truncated or malformed at byte {}: needed a number", at_));
    at_ = static_cast<std::size_t>(end - text_.data());
    return value;
  }
  std::string word() {
    peek();
    const auto end = std::min(text_.size(), text_.find_first_of(" \t\r\n;(){}", at_));
    std::string found = text_.substr(at_, end - at_);
    at_ = end;
    return found;
  }
  /// Moves behind `needed`, or fails with what was looked for.
  void seek(const std::string& needed) {
    const auto found = text_.find(needed, at_);
    if (found == std::string::npos) fail(fmt::format("has no '{}'", needed));
    at_ = found + needed.size();
  }
  Vector3d vector() {
    expect('(');
    Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = number<double>();
    expect(')');
    return v;
  }
  /// "N ( item item ... )"
  template <class Item>
  auto list(Item item) {
    const int n = number<int>();
    std::vector<decltype(item())> all;
    all.reserve(static_cast<std::size_t>(n));
    expect('(');
    for (int i = 0; i < n; ++i) all.push_back(item());
    expect(')');
    return all;
  }
  /// "uniform x", or "nonuniform List<type> N ( x x ... )" with the N that is needed.
  template <class Item>
  Eigen::MatrixXd field(int count, int components, Item item) {
    Eigen::MatrixXd values(components, count);
    if (word() == "uniform") {
      values.colwise() = item();
    } else {
      word();  // the type of the list
      const auto items = list(item);
      if (items.size() != static_cast<std::size_t>(count)) fail(fmt::format("has {} values, needed {}", items.size(), count));
      for (int i = 0; i < count; ++i) values.col(i) = items[static_cast<std::size_t>(i)];
    }
    if (!values.allFinite()) fail("has values that are not finite");
    return values;
  }

 private:
  std::string file_, text_;
  std::size_t at_ = 0;
};

/// Centroid of a cell by OpenFOAM's rule: pyramids from the mean of its face centres.
Vector3d cell_centre(const PolyMesh& mesh, int cell, const std::vector<int>& faces) {
  Vector3d apex = Vector3d::Zero(), moment = Vector3d::Zero();
  double volume = 0.0;
  std::vector<FaceGeometry> geometry;
  for (const int f : faces) geometry.push_back(face_geometry(mesh, f)), apex += geometry.back().centre;
  apex /= static_cast<double>(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const double outward = mesh.owner[static_cast<std::size_t>(faces[i])] == cell ? 1.0 : -1.0;
    const double pyramid = outward * geometry[i].area_vector.dot(geometry[i].centre - apex);
    volume += pyramid;
    moment += pyramid * (0.75 * geometry[i].centre + 0.25 * apex);
  }
  return moment / volume;
}

}  // namespace

int PolyMesh::cells() const {
  int last = -1;
  for (const auto* of_faces : {&owner, &neighbour})
    for (const int cell : *of_faces) last = std::max(last, cell);
  return last + 1;
}

const PolyMesh::Patch& PolyMesh::patch(const std::string& name) const {
  std::string known;
  for (const Patch& p : patches) {
    if (p.name == name) return p;
    known += " " + p.name;
  }
  throw std::runtime_error(fmt::format("the mesh has no patch '{}', only:{}", name, known));
}

PolyMesh read_poly_mesh(const fs::path& folder) {
  PolyMesh mesh;
  Scanner points(folder / "points"), faces(folder / "faces"), owner(folder / "owner"), neighbour(folder / "neighbour"),
      boundary(folder / "boundary");
  mesh.points = points.list([&] { return points.vector(); });
  mesh.faces = faces.list([&] { return faces.list([&] { return faces.number<int>(); }); });
  mesh.owner = owner.list([&] { return owner.number<int>(); });
  mesh.neighbour = neighbour.list([&] { return neighbour.number<int>(); });
  mesh.patches = boundary.list([&] {
    PolyMesh::Patch patch{boundary.word()};
    boundary.seek("nFaces");
    patch.faces = boundary.number<int>();
    boundary.seek("startFace");
    patch.first_face = boundary.number<int>();
    boundary.seek("}");
    return patch;
  });
  const auto count = static_cast<int>(mesh.faces.size());
  if (mesh.owner.size() != mesh.faces.size()) faces.fail(fmt::format("has {} faces, but owner has {}", count, mesh.owner.size()));
  for (const auto& patch : mesh.patches)
    if (patch.first_face < 0 || patch.faces < 0 || patch.first_face + patch.faces > count)
      boundary.fail("patch " + patch.name + " lies outside the faces");
  for (const auto& face : mesh.faces)
    for (const int p : face)
      if (p < 0 || static_cast<std::size_t>(p) >= mesh.points.size())
        faces.fail(fmt::format("point {} is outside the {} points", p, mesh.points.size()));
  return mesh;
}

void write_points(const fs::path& folder, const std::vector<Vector3d>& points) {
  std::ofstream out(folder / "points");
  out << "FoamFile { version 2.0; format ascii; class vectorField; object points; }\n" << points.size() << "\n(\n";
  for (const Vector3d& p : points) out << fmt::format("({:.12g} {:.12g} {:.12g})\n", p.x(), p.y(), p.z());
  out << ")\n";
  if (!out.flush()) throw std::runtime_error(fmt::format("cannot write {}: is the disk full?", (folder / "points").string()));
}

void write_poly_mesh(const fs::path& folder, const PolyMesh& mesh) {
  fs::create_directories(folder);
  write_points(folder, mesh.points);
  const auto write = [&](const char* name, const char* type, const auto& items, const auto& text_of) {
    std::ofstream out(folder / name);
    out << fmt::format("FoamFile {{ version 2.0; format ascii; class {}; object {}; }}\n{}\n(\n", type, name, items.size());
    for (const auto& item : items) out << text_of(item) << '\n';
    out << ")\n";
    if (!out.flush()) throw std::runtime_error(fmt::format("cannot write {}: is the disk full?", (folder / name).string()));
  };
  const auto number = [](int cell) { return fmt::format("{}", cell); };
  write("faces", "faceList", mesh.faces, [](const auto& face) { return fmt::format("{}({})", face.size(), fmt::join(face, " ")); });
  write("owner", "labelList", mesh.owner, number);
  write("neighbour", "labelList", mesh.neighbour, number);
  write("boundary", "polyBoundaryMesh", mesh.patches, [](const PolyMesh::Patch& patch) {
    return fmt::format("{} {{ type patch; nFaces {}; startFace {}; }}", patch.name, patch.faces, patch.first_face);
  });
}

std::vector<CellExtent> cell_extents(const PolyMesh& mesh) {
  constexpr double huge = std::numeric_limits<double>::infinity();
  std::vector<CellExtent> extents(static_cast<std::size_t>(mesh.cells()), {Vector3d::Constant(huge), Vector3d::Constant(-huge)});
  const auto add = [&](int cell, const std::vector<int>& corners) {
    CellExtent& extent = extents[static_cast<std::size_t>(cell)];
    for (const int corner : corners) {
      const Vector3d& p = mesh.points[static_cast<std::size_t>(corner)];
      extent = {extent.lower.cwiseMin(p), extent.upper.cwiseMax(p)};
    }
  };
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    add(mesh.owner[face], mesh.faces[face]);
    if (face < mesh.neighbour.size()) add(mesh.neighbour[face], mesh.faces[face]);
  }
  return extents;
}

void write_cell_set(const fs::path& folder, const std::string& name, const std::vector<int>& cells) {
  fs::create_directories(folder / "sets");
  std::ofstream out(folder / "sets" / name);
  out << "FoamFile { version 2.0; format ascii; class cellSet; location \"constant/polyMesh/sets\"; object " << name << "; }\n"
      << cells.size() << "\n(\n";
  for (const int cell : cells) out << cell << "\n";
  out << ")\n";
  if (!out.flush()) throw std::runtime_error(fmt::format("cannot write {}: is the disk full?", (folder / "sets" / name).string()));
}

FaceGeometry face_geometry(const PolyMesh& mesh, int face) {
  const std::vector<int>& corners = mesh.faces[static_cast<std::size_t>(face)];
  const auto corner = [&](std::size_t i) -> const Vector3d& { return mesh.points[static_cast<std::size_t>(corners[i % corners.size()])]; };
  Vector3d mean = Vector3d::Zero(), area = Vector3d::Zero(), moment = Vector3d::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) mean += corner(i) / static_cast<double>(corners.size());
  double weight = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3d triangle = 0.5 * (corner(i + 1) - corner(i)).cross(mean - corner(i));
    area += triangle;
    weight += triangle.norm();
    moment += triangle.norm() * (corner(i) + corner(i + 1) + mean) / 3.0;
  }
  return {weight > 0.0 ? Vector3d(moment / weight) : mean, area};
}

PatchExtent patch_extent(const PolyMesh& mesh, const std::string& patch) {
  PatchExtent extent;
  const auto& range = mesh.patch(patch);
  for (int f = range.first_face; f < range.first_face + range.faces; ++f) {
    const FaceGeometry face = face_geometry(mesh, f);
    extent.area += face.area_vector.norm();
    extent.volume -= face.centre.dot(face.area_vector) / 3.0;  // the normal points out of the air, into the body
  }
  return extent;
}

int lift_edge_cells(PolyMesh& mesh, const std::string& patch) {
  std::vector<bool> fixed(mesh.points.size(), false);
  for (std::size_t f = mesh.neighbour.size(); f < mesh.faces.size(); ++f)
    for (const int p : mesh.faces[f]) fixed[static_cast<std::size_t>(p)] = true;
  std::vector<std::vector<int>> faces_of(static_cast<std::size_t>(mesh.cells()));
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    faces_of[static_cast<std::size_t>(mesh.owner[f])].push_back(static_cast<int>(f));
    if (f < mesh.neighbour.size()) faces_of[static_cast<std::size_t>(mesh.neighbour[f])].push_back(static_cast<int>(f));
  }

  // A centroid counts as free at a twelfth of the face's size: half of what a regular edge cell has (a sixth, for three equal squares
  // around a right angle). Lifting one cell lowers nobody much, so a few sweeps settle it; checkMesh has the last word.
  constexpr double kClearance = 1.0 / 12.0;
  constexpr int kSweeps = 20;
  std::set<int> lifted;
  const auto& range = mesh.patch(patch);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool moved = false;
    for (int f = range.first_face; f < range.first_face + range.faces; ++f) {
      const int cell = mesh.owner[static_cast<std::size_t>(f)];
      const auto& faces = faces_of[static_cast<std::size_t>(cell)];
      const FaceGeometry wall = face_geometry(mesh, f);
      const Vector3d into_air = -wall.area_vector.normalized();
      const double needed = kClearance * std::sqrt(wall.area_vector.norm());
      const double found = (cell_centre(mesh, cell, faces) - wall.centre).dot(into_air);
      if (found >= needed) continue;
      std::set<int> inner;
      for (const int g : faces)
        for (const int p : mesh.faces[static_cast<std::size_t>(g)])
          if (!fixed[static_cast<std::size_t>(p)]) inner.insert(p);
      for (const int p : inner) mesh.points[static_cast<std::size_t>(p)] += 1.2 * (needed - found) * into_air;
      if (inner.empty()) continue;  // every point of it is on a patch
      moved = true;
      lifted.insert(cell);
    }
    if (!moved) break;
  }
  return static_cast<int>(lifted.size());
}

Eigen::VectorXd read_cell_scalars(const fs::path& file, int cells) {
  Scanner text(file);
  text.seek("internalField");
  const Eigen::MatrixXd values = text.field(cells, 1, [&] { return Eigen::VectorXd::Constant(1, text.number<double>()); });
  return values.row(0).transpose();
}

Eigen::Matrix3Xd read_patch_vectors(const fs::path& file, const std::string& patch, int faces) {
  Scanner text(file);
  text.seek("boundaryField");
  text.seek("\n    " + patch + "\n");
  text.seek("value");
  return text.field(faces, 3, [&] { return Eigen::VectorXd(text.vector()); });
}

}  // namespace cfd_cases
