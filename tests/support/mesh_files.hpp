#pragma once

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdint>
#include <dragcore/shapes.hpp>
#include <sstream>
#include <string>

/// Mesh files as many programs write them, for tests of those who read them.
namespace mesh_files {

/// A mesh, by default the cube of side 1, in a dialect of ascii STL.
struct Ascii {
  std::string name = "body", before = "", indent = "", line_end = "\n", end_name = "body", after = "";
  bool capitals = false;
  dragcore::TriangleMesh mesh = triangulate(dragcore::Box{}, 1);
  int digits = 17;     ///< that count
  bool fixed = false;  ///< `digits` are those behind the point

  std::string text() const {
    std::ostringstream out;
    out.precision(digits);
    if (fixed) out << std::fixed;
    out << before << "solid " << name << "\n";
    for (const auto& t : mesh.triangles) {
      out << indent << "facet normal 0 0 0\n outer loop\n";
      for (const int i : t) out << "  vertex " << mesh.vertices[static_cast<std::size_t>(i)].transpose() << "\n";
      out << " endloop\nendfacet\n";
    }
    out << "endsolid " << end_name << "\n" << after;
    std::string result = out.str();
    if (capitals) std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::toupper(c); });
    for (std::size_t at = 0; line_end != "\n" && (at = result.find('\n', at)) != std::string::npos; at += line_end.size())
      result.replace(at, 1, line_end);
    return result;
  }
};

/// A mesh, by default the cube of side 1, in binary STL: 80 bytes that begin with `header`, the triangles, `tail`.
struct Binary {
  dragcore::TriangleMesh mesh = triangulate(dragcore::Box{}, 1);
  std::string header = "made by a test", tail = "";

  std::string bytes() const {
    std::string result = header + std::string(80 - header.size(), ' ');
    const auto add = [&](std::uint32_t word) {
      for (int shift = 0; shift < 32; shift += 8) result.push_back(static_cast<char>(word >> shift & 0xFF));
    };
    add(static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
      for (int i = 0; i < 3; ++i) add(0);  // a normal that nobody worked out
      for (const int corner : t)
        for (const double x : mesh.vertices[static_cast<std::size_t>(corner)]) add(std::bit_cast<std::uint32_t>(static_cast<float>(x)));
      result.append(2, '\0');
    }
    return result + tail;
  }
};

/// A cube about the origin as OBJ, of quadrilaterals.
struct ObjCube {
  double side = 1.0;
  std::string after_vertex = "";   ///< behind the coordinates of each
  bool references = false;         ///< corners that also name a texture point or a normal
  bool counted_backwards = false;  ///< each face behind its own four vertices, which it counts from the last

  std::string text() const {
    constexpr int faces[6][4] = {{1, 3, 4, 2}, {5, 6, 8, 7}, {1, 2, 6, 5}, {3, 7, 8, 4}, {1, 5, 7, 3}, {2, 4, 8, 6}};
    std::ostringstream out;
    const auto vertex = [&](int number) {
      out << "v";
      for (const int bit : {1, 2, 4}) out << " " << ((number - 1) & bit ? 0.5 : -0.5) * side;
      out << after_vertex << "\n";
    };
    for (int number = 1; number <= 8 && !counted_backwards; ++number) vertex(number);
    for (const auto& [a, b, c, d] : faces) {
      if (counted_backwards) {
        for (const int number : {a, b, c, d}) vertex(number);
        out << "f -4 -3 -2 -1\n";
      } else if (references) {
        out << "f " << a << "/1/1 " << b << "//1 " << c << "/1 " << d << "\n";
      } else {
        out << "f " << a << " " << b << " " << c << " " << d << "\n";
      }
    }
    return out.str();
  }
};

}  // namespace mesh_files
