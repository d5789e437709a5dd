#pragma once

#include <Eigen/Core>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

namespace dragcore {

/// Throws std::invalid_argument "<what> = <found>, but <needed>" unless `ok`. Vectors are printed in a row.
template <class Value>
void require(bool ok, const std::string& what, const Value& found, const std::string& needed) {
  if (ok) return;
  std::ostringstream message;
  message.precision(std::numeric_limits<double>::max_digits10);
  message << what << " = ";
  if constexpr (requires { found.transpose(); })
    message << "(" << found.transpose() << ")";
  else
    message << found;
  message << ", but " << needed;
  throw std::invalid_argument(message.str());
}

inline void require_finite(const std::string& what, double found) { require(found - found == 0.0, what, found, "it must be finite"); }
inline void require_finite(const std::string& what, const Eigen::Vector3d& found) {
  require(found.allFinite(), what, found, "it must be finite");
}

}  // namespace dragcore
