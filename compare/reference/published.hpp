#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "compare/reference/case_of_record.hpp"
#include "compare/reference/case_selector.hpp"
#include "compare/reference/coefficients.hpp"

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
  CaseSelector cases;
  std::string quantity;           ///< "C_D", "C_L", "C_m", "force_angle_deg"; "C_spin", of bodies that spin in still air
  PublishedValue published;       ///< on its own area
  double area_factor = 1.0;       ///< value on A_ref of docs/conventions.md = area_factor times the published one
  double reynolds_power = 0.0;    ///< the published value goes with Re^power ...
  double reynolds_squared = 0.0;  ///< ... times (1 + this times Re^2), the next term of a series
  std::optional<double> goal;     ///< largest difference that this project asks of its CFD chain: %, or degrees for an angle
  std::string note_label;         ///< row of the note's own table of drag coefficients, or empty

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
  std::string flow_model;
  bool of_record = true;  ///< false: an alternative of the case of record
  std::string quantity;
  double cfd = 0.0;
  double u = 0.0;         ///< numerical standard uncertainty of `cfd`: what the method leaves open is what the check is to show [asme_vv20]
  double u_method = 0.0;  ///< as stated in method_uncertainty.toml
  bool discretisation_assessed = false;
  PublishedValue published;
  std::optional<double> goal;

  /// An angle is compared in degrees: a percentage of an angle says nothing.
  bool is_angle() const { return quantity.ends_with("_deg"); }
  const char* unit() const { return is_angle() ? "\u00b0" : " %"; }
  double in_unit(double value) const { return is_angle() ? value : 100.0 * value / std::abs(published.value); }
  double difference() const { return cfd - published.value; }
  double difference_percent() const { return 100.0 * difference() / published.value; }
  double difference_in_unit() const { return is_angle() ? difference() : difference_percent(); }
  bool within_goal() const { return !goal || std::abs(difference_in_unit()) <= *goal; }
  double combined_uncertainty() const { return std::hypot(u, published.uncertainty); }
  bool agrees() const { return std::abs(difference()) <= 2.0 * combined_uncertainty(); }
  std::string verdict() const { return std::string(agrees() ? "agrees" : "differs") + (within_goal() ? "" : ", misses its goal"); }
};

/// Every usable case of record, at its finest mesh, for which something was published. The check of the CFD chain itself: where an
/// experiment is of record, the families behind it are checked.
/// @param alternatives  also the other families that are not of record: what another method says of the same pose
std::vector<PublishedCheck> published_checks(const std::vector<case_record::CaseRecord>& records, bool alternatives = false);
std::vector<PublishedCheck> published_checks(const std::vector<CaseOfRecord>& cases, bool alternatives = false);

}  // namespace compare
