#include <catch2/catch.hpp>

#include <dragcore/unknown_word.hpp>

using dragcore::edit_distance;
using dragcore::nearest_word;

TEST_CASE("letters put in, left out, exchanged and swapped count one each", "[support][analytic]") {
  CHECK(edit_distance("cone", "cone") == 0);
  CHECK(edit_distance("kone", "cone") == 1);
  CHECK(edit_distance("coone", "cone") == 1);
  CHECK(edit_distance("cne", "cone") == 1);
  CHECK(edit_distance("ocne", "cone") == 1);
  CHECK(edit_distance("", "cone") == 4);
  CHECK(edit_distance("kitten", "sitting") == 3);
  CHECK(edit_distance("sitting", "kitten") == 3);
}

TEST_CASE("the nearest word is offered, and none where nothing is near", "[support][limit]") {
  const std::vector<std::string> known = {"cone", "cube", "sphere", "consistent"};
  CHECK(nearest_word("cubee", known) == "cube");
  CHECK(nearest_word("shpere", known) == "sphere");
  CHECK(nearest_word("consis", known) == "consistent");  // cut short
  CHECK(nearest_word("co", known).empty());
  CHECK(nearest_word("zeppelin", known).empty());
  CHECK(nearest_word("", known).empty());
  CHECK(nearest_word("cone", {}).empty());
  CHECK(dragcore::unknown_word("shape", "cubee", {"cone", "cube"}) == "unknown shape 'cubee': did you mean cube? Known: cone, cube");
  CHECK(dragcore::unknown_word("shape", "zeppelin", {"cone", "cube"}) == "unknown shape 'zeppelin'; known: cone, cube");
}
