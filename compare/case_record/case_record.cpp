#include "compare/case_record/case_record.hpp"

#include <stdexcept>
#include <utility>

namespace case_record {

namespace {
constexpr std::array<std::pair<Status, const char*>, 6> status_words = {{
    {Status::steady, "steady"},
    {Status::statistically_steady, "statistically_steady"},
    {Status::drifting, "drifting"},
    {Status::diverged, "diverged"},
    {Status::timed_out, "timed_out"},
    {Status::failed, "failed"},
}};
}  // namespace

std::string to_string(Status status) {
  for (const auto& [value, word] : status_words)
    if (value == status) return word;
  throw std::invalid_argument("status " + std::to_string(static_cast<int>(status)) + " is not one of the six of case_record.hpp");
}

Status status_from(const std::string& word) {
  std::string known;
  for (const auto& [value, name] : status_words) {
    if (word == name) return value;
    known += std::string(known.empty() ? "" : ", ") + name;
  }
  throw std::invalid_argument("unknown status '" + word + "'; known: " + known);
}

}  // namespace case_record
