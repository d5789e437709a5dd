#pragma once

#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compare/coefficients.hpp"

namespace compare {

/// A published value that fits a case, on the reference area of docs/conventions.md.
struct PublishedValue {
  double value = 0.0;
  double uncertainty = 0.0;  ///< as published, or judged from the spread between sources; one standard uncertainty
  std::string citation;      ///< key in references.bib
  std::string kind;          ///< "experiment", "DNS", "correlation"
  std::string confidence;    ///< "seen", "digitised", "note": how the number came here
  std::string conversion;    ///< what was done to its reference area; empty when nothing
};

/// One entry of published.toml: a value and the cases that it belongs to.
struct PublishedEntry {
  using Range = std::pair<double, double>;
  std::string shape;
  std::map<std::string, Range> ratios;  ///< "span/chord" or "apex_angle_deg": parameters of the shape, or ratios of two of them
  Range incidence_deg{0.0, 0.0};
  Range yaw_deg{0.0, 0.0};
  Range reynolds{0.0, 0.0};
  std::string quantity;                ///< "C_D", "C_L", "force_angle_deg"
  PublishedValue published;            ///< on its own area
  double area_factor = 1.0;            ///< value on A_ref of docs/conventions.md = area_factor times the published one
  std::optional<double> goal;          ///< largest difference that this project asks of its CFD chain: %, or degrees for an angle
  std::string note_label;              ///< row of the note's own table of drag coefficients, or empty

  bool fits(const case_record::CaseRecord& record) const;
  PublishedValue on_reference_area(const case_record::CaseRecord& record) const;
};

/// All entries, as compiled into the library; the first that fits counts.
const std::vector<PublishedEntry>& published_entries();

/// The value of `quantity` published for this body, pose and Reynolds number, if there is one.
std::optional<PublishedValue> published_value(const case_record::CaseRecord& record, const std::string& quantity);

/// One quantity of one case against its published value.
struct PublishedCheck {
  std::string case_name;
  std::string quantity;
  double cfd = 0.0;
  PublishedValue published;
  std::optional<double> goal;

  /// An angle is compared in degrees: a percentage of an angle says nothing.
  bool is_angle() const { return quantity.ends_with("_deg"); }
  const char* unit() const { return is_angle() ? "\u00b0" : " %"; }
  double difference() const { return cfd - published.value; }
  double difference_percent() const { return 100.0 * difference() / published.value; }
  double difference_in_unit() const { return is_angle() ? difference() : difference_percent(); }
  bool within_goal() const { return !goal || std::abs(difference_in_unit()) <= *goal; }
};

/// Every usable case, at its finest mesh, for which something was published. The check of the CFD chain itself.
std::vector<PublishedCheck> published_checks(const std::vector<case_record::CaseRecord>& records);

}  // namespace compare
