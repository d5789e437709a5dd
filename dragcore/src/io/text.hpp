#pragma once

#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#ifndef __cpp_lib_to_chars
#include <locale>
#include <sstream>
#endif

/// What the readers of text share. Nothing here reads past the end of what it is given.
namespace dragcore {

/// All bytes of a file. @throws std::runtime_error with the fault alone, without the file's name
inline std::string bytes_of(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) throw std::runtime_error("no such file");
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) throw std::runtime_error("cannot be read; check its permissions");
  std::string bytes(static_cast<std::size_t>(in.tellg()), '\0');
  in.seekg(0);
  if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) throw std::runtime_error("cannot be read to its end");
  return bytes;
}

/// Without the mark that some editors put before UTF-8.
inline std::string_view without_mark(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

/// Two bytes a letter, with the mark before them or, as the first letters show, without.
inline bool is_utf16(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) return true;
  return bytes.size() >= 4 && (bytes[0] == '\0') != (bytes[1] == '\0') && (bytes[2] == '\0') != (bytes[3] == '\0') &&
         (bytes[0] == '\0') == (bytes[2] == '\0');
}

inline bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// Takes the next word off a text; empty where there is none.
inline std::string_view take_word(std::string_view& rest) {
  std::size_t begin = 0;
  while (begin < rest.size() && is_blank(rest[begin])) ++begin;
  std::size_t end = begin;
  while (end < rest.size() && !is_blank(rest[end])) ++end;
  const std::string_view word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

/// The first 40 bytes of a word in quotes, for messages. All but printable ASCII becomes \xHH, so that no file can steer a terminal.
inline std::string in_quotes(std::string_view word) {
  constexpr std::size_t most = 40;
  constexpr const char* digits = "0123456789abcdef";
  std::string result = "'";
  for (const char c : word.substr(0, most)) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\'' || c == '\\')
      result += {'\\', c};
    else if (byte >= 0x20 && byte < 0x7f)
      result += c;
    else
      result += {'\\', 'x', digits[byte >> 4], digits[byte & 15u]};
  }
  return result + (word.size() > most ? "…'" : "'");
}

/// A number that takes up a whole word, or nothing. A leading + is allowed: exporters write it.
template <class Number>
std::optional<Number> number_of(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  Number value{};
#ifndef __cpp_lib_to_chars
  if constexpr (std::is_floating_point_v<Number>) {  // libc++ has no std::from_chars for them before version 20
    if (word.empty() || word.find_first_not_of("0123456789.eE+-") != std::string_view::npos) return std::nullopt;
    std::istringstream in{std::string(word)};
    in.imbue(std::locale::classic());
    return in >> value && in.peek() == std::istringstream::traits_type::eof() ? std::optional(value) : std::nullopt;
  } else
#endif
  {
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc{} && stop == word.data() + word.size() ? std::optional(value) : std::nullopt;
  }
}

}  // namespace dragcore
