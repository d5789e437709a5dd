#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "io/mesh_readers.hpp"
#include "io/text.hpp"

namespace dragcore {

namespace {

/// Lines of a text, ended by "\n", "\r\n" or "\r"; one that ends with a backslash goes on in the next.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    first_ = ++number_;
    line = take();
    if (!line.ends_with('\\')) return true;
    joined_.assign(line);
    while (joined_.ends_with('\\')) {
      joined_.back() = ' ';
      if (rest_.empty()) break;
      ++number_;
      joined_ += take();
    }
    line = joined_;
    return true;
  }
  std::size_t number() const { return first_; }  ///< of the last line, where it began

 private:
  std::string_view take() {
    std::size_t end = 0;
    while (end < rest_.size() && rest_[end] != '\n' && rest_[end] != '\r') ++end;
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(rest_.size(), end + (rest_.substr(end).starts_with("\r\n") ? 2 : 1)));
    return line;
  }

  std::string_view rest_;
  std::string joined_;
  std::size_t number_ = 0, first_ = 0;
};

/// Something that the file holds and the mesh does not.
struct Ignored {
  std::size_t count = 0, first_line = 0;

  void add(std::size_t line) {
    if (count++ == 0) first_line = line;
  }
  void note(const std::string& what, const std::string& consequence, std::vector<std::string>& notes) const {
    if (count > 0)
      notes.push_back(what + ": " + std::to_string(count) + ", the first in line " + std::to_string(first_line) + ", " + consequence);
  }
};

}  // namespace

/// Vertices and faces; all else in an OBJ file is of no account, and no file that it names is opened.
MeshFile read_obj(std::string_view bytes) {
  if (is_utf16(bytes)) throw std::runtime_error("is text in UTF-16; save it as UTF-8 or ASCII");
  struct Face {
    std::size_t line, first;
  };
  MeshFile file;
  std::vector<Eigen::Vector3d>& vertices = file.mesh.vertices;
  std::vector<Face> faces;
  std::vector<int> corners;  // of one face behind those of the other
  Ignored weights, short_faces, curved_surfaces;
  std::vector<std::string_view> words;
  std::string_view line;
  for (Lines lines(without_mark(bytes)); lines.next(line);) {
    line = line.substr(0, line.find('#'));
    const std::string_view kind = take_word(line);
    if (kind == "surf") curved_surfaces.add(lines.number());
    if (kind != "v" && kind != "f") continue;
    words.clear();
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) words.push_back(word);
    const auto wrong = [&](const std::string& fault) { throw std::runtime_error("line " + std::to_string(lines.number()) + ": " + fault); };
    if (kind == "v") {
      if (words.size() < 3) wrong("a vertex has " + std::to_string(words.size()) + " coordinates; needed: three");
      const auto number = [&](std::size_t i, const char* what) {
        const std::optional<double> value = number_of<double>(words[i]);
        if (!value || !std::isfinite(*value))
          wrong(std::string(what) + " of a vertex is " + in_quotes(words[i]) + "; needed: a finite number");
        return *value;
      };
      Eigen::Vector3d vertex;
      for (std::size_t i = 0; i < 3; ++i) vertex[static_cast<Eigen::Index>(i)] = number(i, "a coordinate");
      vertices.push_back(vertex);
      // A fourth number alone is the weight of a control point of rational curves and surfaces, without meaning in a polygon. Colours are
      // three more.
      if (words.size() == 4 && number(3, "the weight") != 1.0) weights.add(lines.number());
    } else if (words.size() < 3) {
      short_faces.add(lines.number());
    } else {
      faces.push_back({lines.number(), corners.size()});
      const auto count = static_cast<long long>(vertices.size());
      for (const std::string_view word : words) {
        const std::optional<int> given = number_of<int>(word.substr(0, word.find('/')));
        if (!given) wrong("a corner of a face is " + in_quotes(word) + "; needed: the number of a vertex");
        const long long index = *given < 0 ? count + *given : *given - 1LL;  // negative ones count back from the last vertex so far
        if (index < 0) wrong("a face refers to vertex " + std::to_string(*given) + ", of " + std::to_string(count) + " so far");
        corners.push_back(static_cast<int>(index));
      }
    }
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::size_t end = f + 1 < faces.size() ? faces[f + 1].first : corners.size();
    const std::span<const int> face(corners.data() + faces[f].first, end - faces[f].first);
    if (const int largest = *std::max_element(face.begin(), face.end()); static_cast<std::size_t>(largest) >= vertices.size())
      throw std::runtime_error("line " + std::to_string(faces[f].line) + ": a face refers to vertex " + std::to_string(largest + 1LL) +
                               ", but there are " + std::to_string(vertices.size()));
    split_polygon(vertices, face, file.mesh.triangles);
  }
  weights.note("vertices with a weight w", "ignored, for it matters to curves alone: x, y, z are taken as written", file.notes);
  short_faces.note("faces of fewer than three corners", "left out", file.notes);
  curved_surfaces.note("curved surfaces ('surf')", "left out: export polygons", file.notes);
  return file;
}

}  // namespace dragcore
