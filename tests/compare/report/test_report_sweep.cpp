#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "compare/report/report_sweep.hpp"
#include "tests/compare/sample_records.hpp"

using compare::Channel;
using compare::ErrorRow;
using compare::Sweep;

namespace {

/// A report as far as sweeps are concerned: the references and one model.
compare::Report report_of(std::vector<sample::CaseRecord> cases, const compare::ModelChoice& model = {}) {
  compare::Report report;
  report.reference.cases = std::move(cases);
  report.models.push_back({"a law", "none", model, compare::compare_with(report.reference.cases, compare::predictor(model), "a law")});
  return report;
}

const Sweep& sweep_of(const std::vector<Sweep>& list, const std::string& family, const std::string& detail = "") {
  for (const Sweep& sweep : list)
    if (sweep.family == family && sweep.detail == detail) return sweep;
  throw std::runtime_error("no sweep of " + family + " " + detail);
}

std::set<std::string> names_of(const std::vector<const ErrorRow*>& rows) {
  std::set<std::string> names;
  for (const ErrorRow* row : rows) names.insert(row->case_name);
  return names;
}

}  // namespace

TEST_CASE("the cube's yaw sweep has side force and yawing moment, and no pose of other incidence", "[compare][report][regression]") {
  // Two combined poses gave its family a lift: the report then showed C_L and C_m of the yaw sweep, all but zero, and left out errors of
  // -65 % in C_S and -99 % in C_n.
  const auto report = report_of(compare::at_rest(compare::read_reference(SOURCE_FOLDER "/results/reference.h5")).cases);
  const std::string cube = "cube, Re 100000, k_omega_sst";
  const auto list = compare::sweeps(report);
  const Sweep& yaw = sweep_of(list, cube);
  CHECK(yaw.angle == "yaw");
  CHECK(yaw.force == Channel::side);
  CHECK(yaw.moment == Channel::yaw);
  REQUIRE(yaw.cases.size() == 7);
  for (std::size_t i = 0; i < 7; ++i) {
    CHECK(yaw.cases[i]->pose.incidence == 0.0);
    CHECK(yaw.cases[i]->pose.roll == 0.0);
    CHECK(yaw.cases[i]->pose.yaw / sample::deg == Approx(7.5 * static_cast<double>(i)));
  }
  // Far beyond any noise: the law by class has half of the side force and hardly any of the yawing moment, and the sweep shows it.
  const auto by_class = report_of(report.reference.cases, compare::ModelChoice::recommended());
  const auto worst = [&](Channel channel) {
    double largest = 0.0;
    for (const ErrorRow* row : compare::rows_of(by_class.models.front().table, yaw, channel))
      largest = std::max(largest, std::abs(row->relative_error.value_or(0.0)));
    return largest;
  };
  CHECK(worst(Channel::side) > 0.5);
  CHECK(worst(Channel::yaw) > 0.8);
  const auto& table = report.models.front().table;
  CHECK(compare::rows_of(table, yaw, Channel::lift).empty());
  CHECK(compare::rows_of(table, yaw, Channel::pitch).empty());

  // The vertex-on poses make a run of their own, in the channels of incidence; what is left has its whole name.
  const Sweep& vertex = sweep_of(list, cube, "incidence at yaw 45°");
  CHECK(vertex.cases.size() == 3);
  CHECK(vertex.force == Channel::lift);
  CHECK(vertex.moment == Channel::pitch);
  const auto off = names_of(compare::rows_off_sweeps(table, list));
  CHECK(off.contains("cone_incidence-040_yaw-025_re-1e5_fine"));
  for (const ErrorRow& row : table.rows)
    if (row.family == cube && row.roll_deg != 0.0) CHECK(off.contains(row.case_name));
}

TEST_CASE("every case of record is on a sweep or listed beside them, and slugs are unique", "[compare][report][invariance]") {
  const auto report = report_of(compare::at_rest(compare::read_reference(SOURCE_FOLDER "/results/reference.h5")).cases);
  const auto list = compare::sweeps(report);
  const auto& table = report.models.front().table;
  const auto off = names_of(compare::rows_off_sweeps(table, list));
  std::set<std::string> slugs;
  for (const Sweep& sweep : list) CHECK(slugs.insert(sweep.slug()).second);
  for (const ErrorRow& row : table.rows) {
    const bool on = std::any_of(list.begin(), list.end(), [&](const Sweep& sweep) { return sweep.holds(row); });
    INFO(row.case_name);
    CHECK(on != off.contains(row.case_name));
  }
}

TEST_CASE("poses on two lines make two sweeps that share the pose where they cross", "[compare][report][analytic]") {
  std::vector<sample::CaseRecord> cases;
  const auto add = [&](double incidence, double yaw) {
    cases.push_back(sample::record("prism_" + std::to_string(int(incidence)) + "_" + std::to_string(int(yaw)) + "_re-1e5",
                                   dragcore::Prism{}, {.incidence = incidence * sample::deg, .yaw = yaw * sample::deg}));
  };
  for (const double incidence : {0.0, 30.0, 60.0}) add(incidence, 0.0);
  for (const double yaw : {45.0, 90.0}) add(0.0, yaw);
  add(20.0, 10.0);
  const auto report = report_of(cases);
  const auto list = compare::sweeps(report);
  REQUIRE(list.size() == 2);
  CHECK(list[0].angle == "incidence");
  CHECK(list[0].detail.empty());
  CHECK(list[1].detail == "yaw");
  CHECK(list[1].force == Channel::side);
  CHECK(list[0].cases.front() == list[1].cases.front());
  CHECK(names_of(compare::rows_off_sweeps(report.models.front().table, list)) == std::set<std::string>{"prism_20_10_re-1e5_medium"});
}
