#pragma once

#include <algorithm>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace dragcore {

/// Letters to put in, leave out, exchange or swap with their neighbour to turn one word into the other.
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) now[j] = std::min(now[j], before[j - 2] + 1);
    }
    before.swap(last);
    last.swap(now);
  }
  return last[b.size()];
}

/// The known word that is meant, as far as spelling tells; empty where none is near: at most one letter in three is wrong.
inline std::string nearest_word(std::string_view word, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    // A word cut short ("consist") is meant, however much is missing.
    const bool cut = word.size() >= 3 && candidate.starts_with(word);
    if (const std::size_t distance = cut ? 1 : edit_distance(word, candidate); distance < least) least = distance, nearest = candidate;
  }
  return nearest;
}

/// "unknown law 'nte': did you mean note? Known: note, consistent"
inline std::string unknown_word(std::string_view what, std::string_view word, const std::vector<std::string>& known) {
  std::string text = "unknown " + std::string(what) + " '" + std::string(word) + "'";
  if (const std::string nearest = nearest_word(word, known); !nearest.empty()) text += ": did you mean " + nearest + "?";
  text += text.back() == '?' ? " Known: " : "; known: ";
  for (std::size_t i = 0; i < known.size(); ++i) text += (i > 0 ? ", " : "") + known[i];
  return text;
}

}  // namespace dragcore
