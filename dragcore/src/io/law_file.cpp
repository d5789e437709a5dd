#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <dragcore/law_file.hpp>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

namespace {
[[noreturn]] void malformed() { throw std::runtime_error("malformed value, a broken date or time perhaps"); }
}  // namespace

// toml++ 3.3 takes for certain what bytes from outside may break ("T" in a date is followed by a digit): it aborts in debug builds and
// assumes it in others. Checked here in every build, a breach is one more fault of the text.
#undef NDEBUG
#define TOML_ASSERT(certain) ((certain) ? static_cast<void>(0) : malformed())
// Compiled in, so that nobody who links the library needs toml++.
#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

namespace dragcore {

namespace {

// A law takes 1 kB with all its provenance.
constexpr std::size_t most_bytes = 1'000'000;

using Number = std::pair<const char*, double Law::*>;
using Coefficients = std::pair<const char*, Law::Polynomial Law::*>;

constexpr std::array polynomials{Coefficients{"windward", &Law::windward}, Coefficients{"leeward", &Law::leeward}};
constexpr std::array numbers{Number{"friction", &Law::friction},
                             Number{"base_suction", &Law::base_suction},
                             Number{"base_edge", &Law::base_edge},
                             Number{"aspect_gain", &Law::aspect_gain},
                             Number{"aspect_scale", &Law::aspect_scale},
                             Number{"recovery", &Law::recovery},
                             Number{"recovery_depth", &Law::recovery_depth},
                             Number{"recovery_edge", &Law::recovery_edge},
                             Number{"shelter", &Law::shelter},
                             Number{"curvature", &Law::curvature},
                             Number{"stokes", &Law::stokes},
                             Number{"layer", &Law::layer},
                             Number{"layer_curvature", &Law::layer_curvature}};
// A number that Law gains must be read and written here too.
static_assert(sizeof(Law) == sizeof(std::string) + polynomials.size() * sizeof(Law::Polynomial) + numbers.size() * sizeof(double));

[[noreturn]] void fail(const std::string& name, const std::string& fault) { throw std::runtime_error("law file " + name + ": " + fault); }

[[noreturn]] void fail(const std::string& name, const toml::source_region& at, const std::string& fault) {
  fail(name, "line " + std::to_string(at.begin.line) + ", column " + std::to_string(at.begin.column) + ": " + fault);
}

/// What a value is, in words for people.
std::string kind(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

double number(const std::string& name, const std::string& key, const toml::node& node) {
  if (!node.is_number()) fail(name, node.source(), key + " is " + kind(node) + "; needed: a number");
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  return node.as_floating_point()->get();
}

std::string text(const std::string& name, const std::string& key, const toml::node& node) {
  if (!node.is_string()) fail(name, node.source(), key + " is " + kind(node) + "; needed: a text in quotes");
  return node.as_string()->get();
}

Law::Polynomial polynomial(const std::string& name, const std::string& key, const toml::node& node) {
  Law::Polynomial result{};
  const toml::array* list = node.as_array();
  const std::string needed = "a list of " + std::to_string(result.size()) + " numbers, the coefficients of 1, c, c^2, c^3, c^4";
  if (!list) fail(name, node.source(), key + " is " + kind(node) + "; needed: " + needed);
  if (list->size() != result.size())
    fail(name, node.source(), key + " has " + std::to_string(list->size()) + " coefficients; needed: " + needed);
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = number(name, key + "[" + std::to_string(i) + "]", *list->get(i));
  return result;
}

/// Puts one key into the law; false when it has no such number.
bool set(Law& law, const std::string& name, const std::string& key, const toml::node& node) {
  for (const auto& [known, member] : polynomials)
    if (key == known) return law.*member = polynomial(name, key, node), true;
  for (const auto& [known, member] : numbers)
    if (key == known) return law.*member = number(name, key, node), true;
  return false;
}

std::string known_keys() {
  std::string keys = "name";
  for (const auto& entry : polynomials) keys += std::string(", ") + entry.first;
  for (const auto& entry : numbers) keys += std::string(", ") + entry.first;
  return keys + ", [provenance]";
}

LawFile from_table(const toml::table& table, const std::string& name) {
  LawFile result;
  const toml::node* law_name = table.get("name");
  if (!law_name) fail(name, "has no name; needed: name = \"…\"");
  result.law.name = text(name, "name", *law_name);
  if (result.law.name.empty()) fail(name, law_name->source(), "name is empty; needed: what the law shall be called");

  for (const auto& [toml_key, node] : table) {
    const std::string key(toml_key.str());
    if (key == "name") continue;
    if (key == "provenance") {
      const toml::table* provenance = node.as_table();
      if (!provenance) fail(name, node.source(), "provenance is " + kind(node) + "; needed: a table [provenance] of texts");
      for (const auto& [word, value] : *provenance)
        result.provenance[std::string(word.str())] = text(name, "provenance." + std::string(word.str()), value);
      continue;
    }
    // Alone in a law of defaults, so that a number out of range is found where it stands.
    Law alone{.name = result.law.name};
    if (!set(alone, name, key, node)) fail(name, toml_key.source(), "unknown key '" + key + "'; known: " + known_keys());
    try {
      validate(alone);
    } catch (const std::invalid_argument& fault) {
      fail(name, node.source(), fault.what());
    }
    set(result.law, name, key, node);
  }
  return result;
}

std::string decimal(double value) {
  std::array<char, 32> digits;
  std::string word(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
  // Without point or exponent TOML reads a whole number, which has no -0.
  return word.find_first_of(".e") == std::string::npos ? word + ".0" : word;
}

/// In quotes, with everything but printable ASCII as \uXXXX or \UXXXXXXXX. Bytes that are not UTF-8 come out as something else.
std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  while (!text.empty()) {
    auto code = static_cast<std::uint32_t>(static_cast<unsigned char>(text.front()));
    std::size_t bytes = 1;
    if (code == '"' || code == '\\') result += '\\';
    if (code >= 0xc0) {
      bytes = std::min<std::size_t>(text.size(), code >= 0xf0 ? 4 : code >= 0xe0 ? 3 : 2);
      code &= 0x7fu >> bytes;
      for (std::size_t i = 1; i < bytes; ++i) code = code << 6 | (static_cast<unsigned char>(text[i]) & 0x3fu);
    }
    if (code >= 0x20 && code < 0x7f) {
      result += static_cast<char>(code);
    } else {
      constexpr const char* digits = "0123456789ABCDEF";
      result += code < 0x10000 ? "\\u" : "\\U";
      for (int shift = code < 0x10000 ? 12 : 28; shift >= 0; shift -= 4) result += digits[code >> shift & 15u];
    }
    text.remove_prefix(bytes);
  }
  return result + '"';
}

bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

std::string to_toml(const LawFile& file) {
  const Law standard;
  std::string result = "name = " + in_quotes(file.law.name) + "\n";
  for (const auto& [key, member] : polynomials) {
    const Law::Polynomial& coefficients = file.law.*member;
    if (std::equal(coefficients.begin(), coefficients.end(), (standard.*member).begin(), same_bits)) continue;
    result += std::string(key) + " = [";
    for (std::size_t i = 0; i < coefficients.size(); ++i) result += (i ? ", " : "") + decimal(coefficients[i]);
    result += "]  # of 1, c, c^2, c^3, c^4\n";
  }
  for (const auto& [key, member] : numbers)
    if (!same_bits(file.law.*member, standard.*member)) result += std::string(key) + " = " + decimal(file.law.*member) + "\n";
  if (file.provenance.empty()) return result;
  result += "\n[provenance]\n";
  for (const auto& [key, value] : file.provenance) {
    const bool bare =
        !key.empty() && key.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") == std::string::npos;
    result += (bare ? key : in_quotes(key)) + " = " + in_quotes(value) + "\n";
  }
  return result;
}

}  // namespace

LawFile parse_law(std::string_view text, const std::string& name_for_messages) {
  if (text.size() > most_bytes)
    fail(name_for_messages, "has " + std::to_string(text.size()) + " bytes; a law has less than " + std::to_string(most_bytes) +
                                ". It is another kind of file");
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // the mark that some editors put before UTF-8
  // The tables of Unicode in toml++ 3.3 have holes: some letters outside of quotes are undefined behaviour.
  if (const auto* odd = std::find_if(text.data(), text.data() + text.size(), [](char c) { return static_cast<unsigned char>(c) >= 0x80; });
      odd != text.data() + text.size()) {
    const std::string_view before(text.data(), static_cast<std::size_t>(odd - text.data()));
    fail(name_for_messages, "line " + std::to_string(1 + std::count(before.begin(), before.end(), '\n')) + ", column " +
                                std::to_string(before.size() - (before.rfind('\n') + 1) + 1) +
                                ": not an ASCII character; write it in quotes as \\uXXXX, its hexadecimal number in Unicode");
  }
  toml::table table;
  try {
    table = toml::parse(text, name_for_messages);
  } catch (const toml::parse_error& fault) {
    fail(name_for_messages, fault.source(), "is not TOML: " + std::string(fault.description()));
  } catch (const std::runtime_error& fault) {
    fail(name_for_messages, std::string("is not TOML: ") + fault.what());
  }
  return from_table(table, name_for_messages);
}

LawFile read_law(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) fail(file.string(), "no such file");
  std::ifstream in(file, std::ios::binary);
  std::string text;
  text.resize(most_bytes + 1);
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad() || (!in.eof() && in.fail())) fail(file.string(), "cannot be read");
  text.resize(static_cast<std::size_t>(in.gcount()));
  return parse_law(text, file.string());
}

std::string law_text(const LawFile& law) {
  validate(law.law);
  std::string text = to_toml(law);
  // A name that is missing, text that is not UTF-8: whatever the reader would refuse or take for something else is refused now.
  try {
    if (parse_law(text, law.law.name) != law) throw std::runtime_error("name or provenance holds text that is not UTF-8");
  } catch (const std::runtime_error& fault) {
    throw std::invalid_argument(std::string("write_law: the file could not be read again: ") + fault.what());
  }
  return text;
}

void write_law(const std::filesystem::path& file, const LawFile& law) {
  const std::string text = law_text(law);
  const std::filesystem::path partial = file.string() + ".partial";
  std::ofstream out(partial, std::ios::binary);
  if (!(out << text).flush()) {
    std::error_code ignored;  // the first fault is the one to report
    std::filesystem::remove(partial, ignored);
    fail(file.string(), "cannot be written; check the folder and the free space");
  }
  out.close();
  std::error_code fault;
  std::filesystem::rename(partial, file, fault);
  if (fault) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    fail(file.string(), "cannot be put in its place: " + fault.message());
  }
}

}  // namespace dragcore
