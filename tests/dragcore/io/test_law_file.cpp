#include <catch2/catch.hpp>
#include <cstring>
#include <dragcore/law_file.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include "tests/support/folder.hpp"

using namespace dragcore;
using Catch::Contains;
using support::Folder;
namespace fs = std::filesystem;

namespace {

std::string contents(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The numbers of a law, which stand behind its name one after the other; == would take -0 for 0.
bool same_bits(const Law& a, const Law& b) {
  const auto bytes = [](const Law& law) { return reinterpret_cast<const char*>(law.windward.data()); };
  const std::size_t size = reinterpret_cast<const char*>(&a + 1) - bytes(a);
  return a.name == b.name && size == 23 * sizeof(double) && std::memcmp(bytes(a), bytes(b), size) == 0;
}

}  // namespace

TEST_CASE("each law that is shipped as a file is the built-in law of its name, to the bit, and says where it comes from",
          "[dragcore][law_file][regression]") {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(LAWS_FOLDER)) files += entry.path().extension() == ".toml";
  CHECK(files == static_cast<int>(law_names().size()));
  for (const std::string& name : law_names()) {
    const fs::path file = fs::path(LAWS_FOLDER) / (name + ".toml");
    INFO(file);
    const LawFile found = read_law(file);
    CHECK(found.law == named_law(name));
    CHECK(same_bits(found.law, named_law(name)));
    for (const char* key : {"command", "errors", "fitted_to", "validity"}) {
      INFO(key);
      REQUIRE(found.provenance.count(key) == 1);
      CHECK_FALSE(found.provenance.at(key).empty());
    }
  }
}

TEST_CASE("a law written to a file comes back to the bit", "[dragcore][law_file]") {
  const Folder folder;
  const fs::path file = folder.path / "law.toml";
  const auto check_round_trip = [&](const LawFile& law) {
    write_law(file, law);
    INFO(contents(file));
    const LawFile back = read_law(file);
    CHECK(same_bits(back.law, law.law));
    CHECK(back.provenance == law.provenance);
  };
  for (const std::string& name : law_names()) check_round_trip({named_law(name), {{"source", "test"}}});

  // Numbers that a short decimal form would spoil, zero that is negative where the default is positive, text that TOML must escape.
  const double tiny = std::numeric_limits<double>::denorm_min(), largest = std::numeric_limits<double>::max();
  const Law odd{.name = "odd \"law\" \\ of\tmine: ü",
                .windward = {-0.0, 1.0 / 3.0, -largest, tiny, 1e22},
                .leeward = {0.0, 0.0, 0.0, 0.0, -0.0},
                .friction = -0.0,
                .base_suction = 0.1 + 0.2,
                .base_edge = tiny,
                .aspect_gain = 999999.99999999988,
                .aspect_scale = 24.000000000000004,
                .recovery = 0.99999999999999989};
  check_round_trip(
      {odd,
       {{"plain-key_1",
         "two\nlines, a quote \", a backslash \\, the control characters \x01 and \x7f, \xC3\xBC, \xE2\x86\x92, \xF0\x9F\x8C\xAC"},
        {"", "no key"},
        {"a b.c", ""}}});

  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit;
  for (int i = 0; i < 50; ++i) {
    Law law{.name = "random"};
    for (Law::Polynomial* p : {&law.windward, &law.leeward})
      for (double& x : *p) x = unit(random) - 0.5;
    for (double* x : {&law.friction, &law.base_suction, &law.base_edge, &law.aspect_gain, &law.aspect_scale, &law.recovery,
                      &law.recovery_depth, &law.recovery_edge, &law.shelter, &law.curvature})
      *x = unit(random);
    check_round_trip({law, {}});
  }
  for (const auto& entry : fs::directory_iterator(folder.path)) CHECK(entry.path().filename() == "law.toml");  // nothing is left beside it
}

TEST_CASE("a law file holds what differs from the defaults, one key per line", "[dragcore][law_file]") {
  const Folder folder;
  write_law(folder.path / "plate.toml", {{.name = "plate", .windward = {0, 1.98, -0.78, 0, 0}, .friction = 0.022}, {{"source", "here"}}});
  CHECK(contents(folder.path / "plate.toml") ==
        "name = \"plate\"\nwindward = [0.0, 1.98, -0.78, 0.0, 0.0]  # of 1, c, c^2, c^3, c^4\nfriction = 0.022\n\n[provenance]\nsource = "
        "\"here\"\n");
  // What is left out keeps its default; whole numbers are numbers.
  Law expected{.name = "bare", .windward = {0, 0, 2, -1, 0}};
  expected.recovery = 1.0;
  CHECK(same_bits(parse_law("name = 'bare'\nrecovery = 1\nwindward = [0, 0, 2, -1, 0]", "text").law, expected));
  CHECK(same_bits(parse_law("\xEF\xBB\xBFname = 'bare'\r\n", "text").law, Law{.name = "bare"}));  // a byte-order mark, Windows line ends
}

TEST_CASE("a law file with a fault is refused with file, line, column, value found and value needed", "[dragcore][law_file][hard]") {
  const auto refused = [](const std::string& text, const std::string& place, const std::string& what) {
    INFO(text);
    CHECK_THROWS_AS(parse_law(text, "bad.toml"), std::runtime_error);
    CHECK_THROWS_WITH(parse_law(text, "bad.toml"), Contains("law file bad.toml: " + place) && Contains(what));
  };
  refused("", "has no name", "needed: name");
  refused("friction = 0.1", "has no name", "needed: name");
  refused("name = ''", "line 1, column 8", "name is empty");
  refused("name = 3", "line 1, column 8", "name is a number; needed: a text");
  refused("name = 'x'\nfriktion = 0.1", "line 2, column 1", "unknown key 'friktion'; known: name, windward, leeward, friction");
  refused("name = 'x'\n[law]\nfriction = 0.1", "line 2, column 2", "unknown key 'law'");
  refused("name = 'x'\nfriction = '0.1'", "line 2, column 12", "friction is a text; needed: a number");
  refused("name = 'x'\nfriction = true", "line 2, column 12", "friction is true or false; needed: a number");
  refused("name = 'x'\nfriction = 2020-01-01", "line 2, column 12", "friction is a date or time; needed: a number");
  refused("name = 'x'\nfriction = [0.1]", "line 2, column 12", "friction is a list; needed: a number");
  refused("name = 'x'\nfriction = {}", "line 2, column 12", "friction is a table; needed: a number");
  refused("name = 'x'\n\nwindward = 2.0", "line 3, column 12", "windward is a number; needed: a list of 5 numbers");
  refused("name = 'x'\nwindward = [0.0, 1.0, 2.0, 3.0]", "line 2, column 12", "windward has 4 coefficients; needed: a list of 5");
  refused("name = 'x'\nleeward = [0, 0, 0, 0, 0, 0]", "line 2, column 11", "leeward has 6 coefficients; needed: a list of 5");
  refused("name = 'x'\nleeward = [0, 0, 'a', 0, 0]", "line 2, column 18", "leeward[2] is a text; needed: a number");
  refused("name = 'x'\nleeward = [0, 0, nan, 0, 0]", "line 2, column 11", "leeward coefficient = nan, but it must be finite");
  refused("name = 'x'\nprovenance = 'me'", "line 2, column 14", "provenance is a text; needed: a table");
  refused("name = 'x'\n[provenance]\ndate = 2020-01-01", "line 3, column 8", "provenance.date is a date or time; needed: a text in quotes");
  // Ranges, as validate() has them; found where they stand.
  refused("name = 'x'\ncurvature = 1.0\nfriction = -0.5", "line 3, column 12", "law 'x': friction = -0.5, but it must be from 0");
  refused("name = 'x'\nrecovery = 1.5", "line 2, column 12", "recovery = 1.5, but it must be from 0 to 1");
  refused("name = 'x'\nbase_edge = 0", "line 2, column 13", "base_edge = 0, but it must be greater than 0");
  refused("name = 'x'\nshelter = inf", "line 2, column 11", "shelter = inf");
  // Not TOML at all.
  refused("name = 'x'\nfriction = ", "line 2", "is not TOML");
  refused("name = 'x'\nname = 'y'", "line 2", "is not TOML");
  refused("solid cube", "line 1", "is not TOML");
  refused(std::string("name = 'x'\0", 11), "line 1", "is not TOML");
  refused("name = 'x'\nfriction = 0.1 # r\xC3\xBC", "line 2, column 19", "not an ASCII character");
  refused("name = '\xff'", "line 1, column 9", "not an ASCII character");
  // What toml++ 3.3 does not expect: found by tests/fuzz.
  refused("\xEF\xBB\xBF\xEF\xAF\xAF = 1", "line 1, column 1", "not an ASCII character");
  refused(
      "name = 'x'\nfriction = 2020-01-01T\x14"
      "00:00:00",
      "is not TOML", "date or time");
  refused("name = 'x'\nleeward = " + std::string(5000, '['), "line 2", "is not TOML");
  refused("name = 'x'\n" + std::string(1'000'000, '#'), "has 1000011 bytes", "another kind of file");

  const Folder folder;
  CHECK_THROWS_WITH(read_law(folder.path / "none.toml"), Contains("none.toml: no such file"));
  CHECK_THROWS_WITH(read_law(folder.path), Contains("no such file"));
  CHECK_THROWS_WITH(read_law(folder.write("bad.toml", "name = 'x'\nfriction = -1")),
                    Contains("bad.toml: line 2, column 12: law 'x': friction = -1"));
}

TEST_CASE("a law that could not be read again is not written", "[dragcore][law_file][hard]") {
  const Folder folder;
  const fs::path file = folder.path / "law.toml";
  write_law(file, {note_law(), {}});
  const std::string before = contents(file);
  Law wrong = note_law();
  wrong.recovery = 2.0;
  CHECK_THROWS_WITH(write_law(file, {wrong, {}}), Contains("recovery = 2"));
  CHECK_THROWS_WITH(write_law(file, {Law{}, {}}), Contains("name is empty"));
  // Not UTF-8: a byte alone, a character cut short, one in more bytes than it needs, half of a pair, beyond the last one.
  for (const char* text : {"\xff\xfe", "\x80", "\xE2\x86", "\xE2(", "\xC0\xAF", "\xED\xA0\x80", "\xF7\xBF\xBF\xBF"})
    CHECK_THROWS_AS(write_law(file, {note_law(), {{"source", text}}}), std::invalid_argument);
  CHECK(contents(file) == before);
  CHECK_THROWS_WITH(write_law(folder.path / "no" / "such.toml", {note_law(), {}}), Contains("cannot be written"));
  fs::create_directory(folder.path / "folder.toml");
  CHECK_THROWS_WITH(write_law(folder.path / "folder.toml", {note_law(), {}}), Contains("cannot be put in its place"));
  CHECK_FALSE(fs::exists(folder.path / "folder.toml.partial"));
}
