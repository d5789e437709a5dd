#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include "io/mesh_readers.hpp"
#include "io/text.hpp"

namespace dragcore {

namespace {

constexpr std::size_t header_bytes = 84, triangle_bytes = 50;

[[noreturn]] void fail(const std::string& fault) { throw std::runtime_error(fault); }

/// Adds a triangle with vertices of its own.
void add(TriangleMesh& mesh, const std::array<Eigen::Vector3d, 3>& corners) {
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
  mesh.triangles.emplace_back(first, first + 1, first + 2);
}

/// Text has no zero bytes; a binary file has some in its count of triangles or its first triangle at the latest.
bool is_text(std::string_view bytes) { return bytes.substr(0, header_bytes + triangle_bytes).find('\0') == std::string_view::npos; }

std::uint32_t promised_triangles(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  return count;
}

std::uintmax_t promised_bytes(std::string_view bytes) { return header_bytes + triangle_bytes * std::uintmax_t{promised_triangles(bytes)}; }

/// Bytes behind the last triangle: some programs fill their files up to whole blocks.
void note_tail(std::string_view tail, std::uint32_t count, std::vector<std::string>& notes) {
  if (tail.empty()) return;
  std::string note = "bytes after the last of its " + std::to_string(count) + " triangles: " + std::to_string(tail.size()) + ", ignored";
  if (tail.size() % triangle_bytes == 0 && tail.find_first_not_of('\0') != std::string_view::npos)
    note += ". They have the size of whole triangles, " + std::to_string(tail.size() / triangle_bytes) +
            ": if some are missing, the count in its header is wrong";
  notes.push_back(std::move(note));
}

MeshFile read_binary(std::string_view bytes) {
  const std::uint32_t count = promised_triangles(bytes);
  const std::uintmax_t needed = promised_bytes(bytes);
  if (bytes.size() < needed)
    fail("truncated, or no STL file: its header promises " + std::to_string(count) + " triangles, " + std::to_string(needed) +
         " bytes, but it has " + std::to_string(bytes.size()) + ". Export it again");
  if (count == 0) {
    const std::size_t behind = bytes.size() - header_bytes;
    fail("holds no triangle: its header promises 0" +
         (behind ? ", though " + std::to_string(behind) + " bytes follow. Export it again" : std::string()));
  }
  MeshFile file;
  file.mesh.vertices.reserve(3 * std::size_t{count});
  file.mesh.triangles.reserve(count);
  for (std::uint32_t t = 0; t < count; ++t) {
    std::array<float, 12> numbers;  // the normal, which is of no account, and three corners
    std::memcpy(numbers.data(), bytes.data() + header_bytes + triangle_bytes * std::size_t{t}, sizeof numbers);
    std::array<Eigen::Vector3d, 3> corners;
    for (std::size_t i = 0; i < 9; ++i) {
      const double value = numbers[3 + i];
      if (!std::isfinite(value))
        fail("triangle " + std::to_string(t + 1) + " of " + std::to_string(count) + ": a coordinate is " + std::to_string(value) +
             "; needed: a finite number. Export it again");
      corners[i / 3][static_cast<Eigen::Index>(i % 3)] = value;
    }
    add(file.mesh, corners);
  }
  note_tail(bytes.substr(static_cast<std::size_t>(needed)), count, file.notes);
  return file;
}

/// The words of a text and the lines they stand in.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  /// Empty at the end.
  std::string_view peek() {
    while (!rest_.empty() && is_blank(rest_.front())) {
      const char c = rest_.front();
      rest_.remove_prefix(1);
      // "\n", "\r\n" and "\r" end lines.
      if (c == '\n' || (c == '\r' && !rest_.starts_with('\n'))) ++line_;
    }
    std::string_view rest = rest_;
    return take_word(rest);
  }
  std::string_view next() {
    const std::string_view word = peek();
    rest_.remove_prefix(word.size());
    return word;
  }
  void skip_line() {
    while (!rest_.empty() && rest_.front() != '\n' && rest_.front() != '\r') rest_.remove_prefix(1);
  }
  std::size_t line() const { return line_; }  ///< of the last word

 private:
  std::string_view rest_;
  std::size_t line_ = 1;
};

/// Whether a word is `keyword`, which is in small letters, in letters of any size.
bool is(std::string_view word, std::string_view keyword) {
  if (word.size() != keyword.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i)
    if ((word[i] >= 'A' && word[i] <= 'Z' ? word[i] - 'A' + 'a' : word[i]) != keyword[i]) return false;
  return true;
}

MeshFile read_ascii(std::string_view text) {
  MeshFile file;
  Words words(text);
  const auto wrong = [&](std::string_view found, const std::string& needed) {
    const std::string line = "line " + std::to_string(words.line()) + ": ";
    if (found.empty()) fail(line + "truncated: the file ends where " + needed + " is needed. Export it again");
    fail(line + in_quotes(found) + " where " + needed + " is needed");
  };
  const auto expect = [&](std::string_view keyword) {
    if (const std::string_view found = words.next(); !is(found, keyword)) wrong(found, in_quotes(keyword));
  };
  std::size_t solids = 0, line_outside = 0;
  bool in_solid = false;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (!in_solid && is(word, "solid")) {
      in_solid = true;
      ++solids;
      words.skip_line();  // its name
    } else if (!in_solid) {
      if (is(word, "facet")) wrong(word, "'solid' before it");
      if (line_outside == 0) line_outside = words.line();
      words.skip_line();
    } else if (is(word, "endsolid")) {
      in_solid = false;
      words.skip_line();
    } else {
      if (!is(word, "facet")) wrong(word, "'facet' or 'endsolid'");
      // "normal" and its three numbers are of no account: the corners say it better.
      for (int i = 0; i < 4 && !is(words.peek(), "outer"); ++i) words.next();
      expect("outer"), expect("loop");
      std::array<Eigen::Vector3d, 3> corners;
      for (Eigen::Vector3d& corner : corners) {
        expect("vertex");
        for (double& coordinate : corner) {
          const std::string_view found = words.next();
          const std::optional<double> value = number_of<double>(found);
          if (!value || !std::isfinite(*value)) wrong(found, "a coordinate, a finite number,");
          coordinate = *value;
        }
      }
      expect("endloop"), expect("endfacet");
      add(file.mesh, corners);
    }
  }
  if (in_solid) wrong({}, "'facet' or 'endsolid'");
  if (solids == 0) fail("is text in which no line begins with 'solid'; it is no STL file");
  if (solids > 1) file.notes.push_back("solids: " + std::to_string(solids) + ", read as one mesh");
  if (line_outside > 0) file.notes.push_back("text outside of its solids, the first in line " + std::to_string(line_outside) + ", ignored");
  return file;
}

}  // namespace

MeshFile read_stl(std::string_view bytes) {
  // What a binary file promises fits no text, which may begin with the same word: its size decides.
  if (bytes.size() >= header_bytes && bytes.size() == promised_bytes(bytes)) return read_binary(bytes);
  if (is_utf16(bytes)) fail("is text in UTF-16; save it as UTF-8 or ASCII");
  if (is_text(bytes)) return read_ascii(without_mark(bytes));
  if (bytes.size() < header_bytes)
    fail("only " + std::to_string(bytes.size()) + " bytes; a binary STL file has at least " + std::to_string(header_bytes) +
         ". Export it again");
  return read_binary(bytes);
}

}  // namespace dragcore
