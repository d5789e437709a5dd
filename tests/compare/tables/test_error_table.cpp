#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "compare/store/hdf5.hpp"
#include "compare/tables/error_table.hpp"
#include "tests/compare/sample_records.hpp"

using Catch::Contains;
using compare::Channel;
using compare::ErrorRow;

namespace {

/// A model that knows the answer and adds a fixed error to C_D.
compare::Predictor reference_plus(double drag_error) {
  return [drag_error](const sample::CaseRecord& record) {
    dragcore::Wrench wrench{record.load.force(), record.load.moment()};
    wrench.force.x() += drag_error * compare::coefficient_scales(record)[0];
    return wrench;
  };
}

ErrorRow drag_row(double model, double cfd, double u = 0.0) {
  ErrorRow row;
  row.case_name = "case " + std::to_string(model);
  row.model = model;
  row.cfd = cfd;
  row.u = u;
  row.error = model - cfd;
  return row;
}

const ErrorRow& row_of(const compare::ErrorTable& table, const std::string& name, Channel channel) {
  for (const ErrorRow& row : table.rows)
    if (row.case_name == name && row.channel == channel) return row;
  throw std::runtime_error("no row " + name + " " + compare::symbol(channel));
}

}  // namespace

TEST_CASE("bias, interval, rms and worst case agree with a calculation by hand", "[compare][analytic]") {
  const std::vector<ErrorRow> rows = {drag_row(1.1, 1.0), drag_row(1.2, 1.0), drag_row(1.3, 1.0)};
  const auto s = compare::summarise("group", {&rows[0], &rows[1], &rows[2]});
  CHECK(s.n == 3);
  CHECK(s.bias == Approx(0.2));
  CHECK(s.rms == Approx(std::sqrt(0.14 / 3.0)));
  CHECK(s.worst == Approx(0.3));
  CHECK(s.worst_case == rows[2].case_name);
  // Standard deviation 0.1, Student's t for 2 degrees of freedom 4.302653: 4.302653 * 0.1 / sqrt(3).
  CHECK(s.bias_half_width.value() == Approx(0.248414).epsilon(1e-5));
  const auto single = compare::summarise("group", {&rows[0]});
  CHECK_FALSE(single.bias_half_width);
  CHECK_FALSE(single.bias_factor);
}

TEST_CASE("bias factor and scatter follow the log-normal model", "[compare][analytic]") {
  const std::vector<ErrorRow> exact = {drag_row(1.2, 1.0), drag_row(2.4, 2.0)};
  const auto s = compare::summarise("group", {&exact[0], &exact[1]});
  CHECK(s.bias_factor.value() == Approx(1.2).epsilon(1e-12));  // always 20 % high, no scatter
  CHECK(s.scatter.value() == Approx(0.0).margin(1e-8));
  // ln ratios -+a around 0: variance 2 a^2, less the noise of the reference, 0.05^2.
  const double a = 0.1;
  const std::vector<ErrorRow> scattered = {drag_row(std::exp(a), 1.0, 0.05), drag_row(std::exp(-a), 1.0, 0.05)};
  const auto t = compare::summarise("group", {&scattered[0], &scattered[1]});
  CHECK(t.scatter.value() == Approx(std::sqrt(2 * a * a - 0.0025)).epsilon(1e-12));
  CHECK(t.bias_factor.value() == Approx(std::exp(0.5 * (2 * a * a - 2 * 0.0025))).epsilon(1e-12));
}

TEST_CASE("a model that is the reference has no error in any channel, and nothing is resolved", "[compare][analytic]") {
  const auto table = compare::compare_with(sample::quick_tier(), reference_plus(0.0), "itself");
  CHECK(table.compared == 12);
  for (const ErrorRow& row : table.rows) {
    REQUIRE(row.error);
    CHECK(*row.error == Approx(0.0).margin(1e-12));
    CHECK(row.verdict == compare::Verdict::within_noise);
  }
}

TEST_CASE("an error is resolved beyond twice the uncertainty of the reference", "[compare][limit]") {
  auto records = sample::quick_tier();
  for (auto& record : records) record.flow_model = "laminar";  // no part of the method in u
  // u of the force is 0.005 N (3-4-5), q A of the cube 2.4 N.
  const double u = 0.005 / 2.4;
  const auto verdict = [&](double error) {
    return *row_of(compare::compare_with(records, reference_plus(error), "off"), "cube_yaw-000_re-1e5_medium", Channel::drag).verdict;
  };
  CHECK(verdict(1.99 * u) == compare::Verdict::within_noise);
  CHECK(verdict(2.01 * u) == compare::Verdict::resolved);
  CHECK(verdict(-2.01 * u) == compare::Verdict::resolved);
}

TEST_CASE("zero against zero is not resolved, even where symmetry leaves no uncertainty", "[compare][regression]") {
  // Half models of real cases have side forces of 1e-17 with u = 0, and such rows once stood in the table as resolved.
  auto records = sample::quick_tier();
  for (auto& record : records) {
    record.u_iteration.setZero();
    record.u_statistical.setZero();
  }
  const auto row = row_of(compare::compare_with(records, reference_plus(1e-15), "off"), "cube_yaw-000_re-1e5_medium", Channel::drag);
  CHECK(row.verdict == compare::Verdict::within_noise);
}

TEST_CASE("each shape is compared in the channels that its poses drive", "[compare][sign]") {
  const auto table = compare::compare_with(sample::quick_tier(), compare::predictor({}), "note");
  CHECK_NOTHROW(row_of(table, "plate_incidence-030_re-1e5_medium", Channel::lift));
  CHECK_NOTHROW(row_of(table, "plate_incidence-030_re-1e5_medium", Channel::pitch));
  CHECK_THROWS(row_of(table, "plate_incidence-030_re-1e5_medium", Channel::side));
  // At zero yaw the cube is a member of a family that is yawed.
  CHECK_NOTHROW(row_of(table, "cube_yaw-000_re-1e5_medium", Channel::side));
  CHECK_NOTHROW(row_of(table, "cube_yaw-015_re-1e5_medium", Channel::yaw));
  CHECK_THROWS(row_of(table, "cube_yaw-015_re-1e5_medium", Channel::lift));
}

TEST_CASE("a combined pose is compared in all lateral channels and adds none to its family's sweeps", "[compare][regression]") {
  auto records = sample::quick_tier();
  records.push_back(
      sample::record("cube_incidence-015_yaw-045_re-1e5", dragcore::Box{}, {.incidence = 15 * sample::deg, .yaw = 45 * sample::deg}));
  const auto table = compare::compare_with(records, compare::predictor({}), "note");
  for (const Channel channel : {Channel::side, Channel::lift, Channel::pitch, Channel::yaw})
    CHECK_NOTHROW(row_of(table, "cube_incidence-015_yaw-045_re-1e5_medium", channel));
  // Its lift used to give the yawed and the straight cube one, too: rows of zeros that made the rms error of C_L small.
  for (const char* name : {"cube_yaw-000_re-1e5_medium", "cube_yaw-015_re-1e5_medium"}) {
    CHECK_THROWS(row_of(table, name, Channel::lift));
    CHECK_THROWS(row_of(table, name, Channel::pitch));
    CHECK_NOTHROW(row_of(table, name, Channel::side));
  }
}

TEST_CASE("a centre of pressure known to no better than a length of the body is left out, with its reason", "[compare][regression]") {
  auto records = sample::quick_tier();
  const std::string name = "plate_incidence-030_re-1e5_medium";
  const auto before = row_of(compare::compare_with(records, compare::predictor({}), "note"), name, Channel::centre_of_pressure);
  REQUIRE(before.cfd);
  // The force keeps its u; the moment's grows until x_cp is known to some lengths only.
  for (auto& record : records)
    if (record.name == name) record.u_iteration.tail<3>().setConstant(10.0);
  const auto table = compare::compare_with(records, compare::predictor({}), "note");
  const ErrorRow& row = row_of(table, name, Channel::centre_of_pressure);
  CHECK_FALSE(row.cfd);
  CHECK_FALSE(row.error);
  CHECK(row.model);
  CHECK(row.u == 0.0);
  CHECK_THAT(row.reason, Contains("lengths of the body"));
  CHECK(row_of(table, name, Channel::pitch).cfd);
  CHECK(row_of(table, name, Channel::pitch).reason.empty());
  CHECK_THAT(compare::render(table, compare::Format::table), Contains("not known: its u is"));
}

TEST_CASE("a choice of cases leaves their rows as they are among all others, and totals are those of the rows shown",
          "[compare][invariance]") {
  const auto records = sample::quick_tier();
  const auto all = compare::compare_with(records, compare::predictor({}), "note");
  const auto shown = [](const std::string& name) { return name.starts_with("cube_yaw-015"); };
  const auto some = compare::compare_with(records, compare::predictor({}), "note", {"sphere_medium"}, {}, shown);
  CHECK(some.compared == 1);
  REQUIRE(some.rows.size() >= 3);
  for (const ErrorRow& row : some.rows) {
    const ErrorRow& same = row_of(all, row.case_name, row.channel);
    CHECK(shown(row.case_name));
    CHECK(row.u == same.u);
    CHECK(row.relative_error == same.relative_error);
  }
  REQUIRE_FALSE(some.totals.empty());
  CHECK(some.totals.front().channel == Channel::drag);
  CHECK(some.totals.front().n == 1);
  CHECK(some.totals.front().rms == Approx(std::abs(*row_of(all, "cube_yaw-015_re-1e5_medium", Channel::drag).error)));
  CHECK(all.totals.front().n == 12);
}

TEST_CASE("a lateral force that symmetry makes zero has an error but no relative error", "[compare][limit]") {
  const auto table = compare::compare_with(sample::quick_tier(), compare::predictor({}), "note");
  const ErrorRow& null = row_of(table, "cube_yaw-000_re-1e5_medium", Channel::side);
  CHECK(null.error);
  CHECK_FALSE(null.relative_error);
  const ErrorRow& drag = row_of(table, "cube_yaw-000_re-1e5_medium", Channel::drag);
  CHECK(drag.relative_error.value() == Approx(*drag.error / std::abs(*drag.cfd)));
}

TEST_CASE("failed and missing cases stand in the table with their reason and count as not compared", "[compare][regression]") {
  auto records = sample::quick_tier();
  records[2].status = case_record::Status::diverged;
  records[2].reason = "C_D reached -2e4";
  const auto table = compare::compare_with(records, compare::predictor({}), "note", {"sphere_incidence-000_re-1e2_medium"});
  CHECK(table.compared == 11);
  const ErrorRow& failed = row_of(table, records[2].name, Channel::drag);
  CHECK_FALSE(failed.cfd);
  CHECK_FALSE(failed.error);
  CHECK(failed.model);
  CHECK(table.rows.back().status == "missing");
  for (const auto& summary : table.summaries) CHECK(summary.worst_case != records[2].name);
  for (const compare::Format format : {compare::Format::table, compare::Format::markdown, compare::Format::csv, compare::Format::json}) {
    const std::string text = compare::render(table, format);
    CHECK_THAT(text, Contains("diverged") && Contains("C_D reached -2e4"));
    CHECK_THAT(text, Contains("missing") && Contains("sphere_incidence-000_re-1e2_medium"));
  }
}

TEST_CASE("statistics group by what is asked for", "[compare][analytic]") {
  const auto records = sample::quick_tier();
  const auto groups = [&](const std::vector<compare::GroupBy>& by) {
    std::set<std::string> names;
    int n = 0;
    for (const auto& s : compare::compare_with(records, compare::predictor({}), "note", {}, by).summaries)
      if (s.channel == Channel::drag) names.insert(s.group), n += s.n;
    CHECK(n == 12);
    return names;
  };
  CHECK(groups({}).size() == 3);
  CHECK(groups({compare::GroupBy::shape}) == std::set<std::string>{"cone", "cube", "plate"});
  CHECK(groups({compare::GroupBy::reynolds}).size() == 1);
  CHECK(groups({compare::GroupBy::shape, compare::GroupBy::orientation}).size() == 12);
  CHECK_THROWS_WITH(compare::group_by_from("size"), Contains("shape, orientation, Re"));
}

TEST_CASE("shapes are labelled by what sets them apart", "[compare][analytic]") {
  CHECK(compare::shape_label(dragcore::Plate{}) == "plate");
  CHECK(compare::shape_label(dragcore::Plate{.span = 2.0}) == "plate span=2");
  CHECK(compare::shape_label(dragcore::Box{}) == "cube");
  CHECK(compare::shape_label(dragcore::Box{.length = 2.0}) == "box height=1 length=2 width=1");
}

TEST_CASE("tables are plain text without colour and coloured with it", "[compare][regression]") {
  const auto table = compare::compare_with(sample::quick_tier(), compare::predictor({}), "note");
  const std::string plain = compare::render(table, compare::Format::table, false);
  CHECK(plain.find('\x1b') == std::string::npos);
  CHECK(compare::render(table, compare::Format::table, true).find('\x1b') != std::string::npos);
  CHECK_THAT(plain, Contains("incidence 30°") && Contains("x_cp") && Contains("*"));
  CHECK_THAT(plain, Contains("agrees") || Contains("differs"));
  CHECK(plain.find("-0.000") == std::string::npos);
}

TEST_CASE("machine formats have one entry per row and parse", "[compare][regression]") {
  const auto table = compare::compare_with(sample::quick_tier(), compare::predictor({}), "note");
  const auto document = nlohmann::json::parse(compare::render(table, compare::Format::json));
  CHECK(document["rows"].size() == table.rows.size());
  CHECK(document["rows"][0]["error"].is_number());
  const std::string csv = compare::render(table, compare::Format::csv);
  CHECK(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')) == table.rows.size() + 1);
  const std::string heading = csv.substr(0, csv.find('\n')),
                    first = csv.substr(csv.find('\n') + 1, csv.find('\n', csv.find('\n') + 1) - csv.find('\n') - 1);
  CHECK(std::count(heading.begin(), heading.end(), ',') == std::count(first.begin(), first.end(), ','));
  CHECK_THROWS_WITH(compare::format_from("xls"), Contains("table, md, csv, json"));
}

TEST_CASE("the stored comparison holds both sides and their difference", "[compare][store][analytic]") {
  const sample::Folder folder;
  const auto table = compare::compare_with(sample::quick_tier(), compare::predictor({}), "note");
  compare::write_comparison(folder / "comparison.h5", {table});
  const auto file = compare::hdf5::open_file(folder / "comparison.h5", "dragval comparison", 1);
  const auto group = compare::hdf5::open_group(file, "note");
  const auto model = compare::hdf5::read_table(group, "model"), cfd = compare::hdf5::read_table(group, "cfd"),
             error = compare::hdf5::read_table(group, "error");
  REQUIRE(model.rows() == static_cast<Eigen::Index>(table.rows.size()));
  for (Eigen::Index i = 0; i < model.rows(); ++i)
    if (!std::isnan(error(i))) CHECK(error(i) == Approx(model(i) - cfd(i)).margin(1e-15));
  CHECK(compare::hdf5::read_words(group, "channel")[0] == compare::symbol(table.rows[0].channel));
}
