#pragma once

#include <Eigen/Core>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

namespace dragcore {

/// Throws std::invalid_argument "<what> = <found>, but <needed>" unless `ok`. Vectors are printed in a row.
/// Both texts may be functions that make them: a check that passes must not cost what its message does.
template <class What, class Value, class Needed>
void require(bool ok, const What& what, const Value& found, const Needed& needed) {
  if (ok) [[likely]]
    return;
  const auto text = [](const auto& given) -> std::string {
    if constexpr (requires { given(); })
      return given();
    else
      return given;
  };
  std::ostringstream message;
  message.precision(std::numeric_limits<double>::max_digits10);
  message << text(what) << " = ";
  if constexpr (requires { found.transpose(); })
    message << "(" << found.transpose() << ")";
  else
    message << found;
  message << ", but " << text(needed);
  throw std::invalid_argument(message.str());
}

template <class What>
void require_finite(const What& what, double found) {
  require(found - found == 0.0, what, found, "it must be finite");
}
template <class What>
void require_finite(const What& what, const Eigen::Vector3d& found) {
  require(found.allFinite(), what, found, "it must be finite");
}

}  // namespace dragcore
