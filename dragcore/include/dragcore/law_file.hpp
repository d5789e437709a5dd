#pragma once

#include <dragcore/law.hpp>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

/// Laws in files: TOML, one key per number of Law under its name there, polynomials as lists of five. What a file leaves out keeps its
/// default; only `name` is needed. Files are ASCII; texts may hold any character as \uXXXX. A table [provenance] holds texts: what the
/// numbers were derived from or fitted to, by which command, when, with which errors and where they are valid. The laws of named_law() are
/// installed as share/dragcore/laws/*.toml. Part of dragcore::law_files.
namespace dragcore {

struct LawFile {
  Law law{};
  std::map<std::string, std::string> provenance{};  ///< by key; usual are command, errors, fitted_to and validity

  bool operator==(const LawFile&) const = default;
};

/// @throws std::runtime_error  missing file; all that parse_law() refuses
LawFile read_law(const std::filesystem::path& file);

/// @param name_for_messages  what errors call the text: a file's name, say
/// @throws std::runtime_error  text that is not TOML, not ASCII or longer than 1 MB, a key that Law has not, a value of another type, a
/// polynomial without
///                             five coefficients, a number that validate() refuses, no name: which text, line and column, value found,
///                             value needed
LawFile parse_law(std::string_view text, const std::string& name_for_messages);

/// The text of a file: what write_law() writes. @throws std::invalid_argument  as that
std::string law_text(const LawFile& law);

/// Writes the name, every number that differs from its default in the shortest form that reads back to the same bits, and the provenance;
/// under a temporary name beside the file, then renamed. The comments of a file that was there are lost.
/// @throws std::invalid_argument  a law that validate() refuses or that has no name, text that is not UTF-8
/// @throws std::runtime_error     when the file cannot be written
void write_law(const std::filesystem::path& file, const LawFile& law);

}  // namespace dragcore
