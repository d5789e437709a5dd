#pragma once

#include <string>

namespace compare {

/// A text of any size as a script element that runs nothing: gzip in base64, which unpacked() of show.js turns back.
std::string packed(const std::string& id, const std::string& text);

}  // namespace compare
