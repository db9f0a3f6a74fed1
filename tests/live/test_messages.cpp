#include "tools/live/messages.h"

#include <nlohmann/json.hpp>
#include <random>

#include "tests/live/live_scenes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::test;

namespace {

const std::vector<std::string> good{R"({"wish":"play"})",
                                    R"({"wish":"pause"})",
                                    R"({"wish":"set","key":3,"value":0.25})",
                                    R"({"wish":"grab","body":0,"vertex":17,"place":[0.1,2,-3e-1]})",
                                    R"({"wish":"move","place":[1,2,3]})",
                                    R"({"wish":"slower","value":4})",
                                    R"({"wish":"show","frame":12})",
                                    R"({"wish":"seen","frame":4000000})",
                                    R"({"wish":"save"})",
                                    R"({"wish":"place","obstacle":0,"place":[1,2,3]})",
                                    R"({"wish":"cells","body":0,"cells":120})"};

/// Bytes of any kind, or a good message with some of its bytes changed, doubled or cut.
std::string random_message(std::mt19937& random) {
  const auto below = [&](std::size_t n) { return std::size_t(random() % n); };
  std::string text;
  if (random() % 3 == 0) {
    text.resize(below(80));
    for (char& c : text) c = char(random());
    return text;
  }
  text = good[below(good.size())];
  for (std::size_t changes = below(4) + 1; changes > 0 && !text.empty(); --changes) {
    const std::size_t at = below(text.size());
    switch (random() % 4) {
      case 0:
        text[at] = char(random());
        break;
      case 1:
        text.insert(at, text.substr(at, below(12)));
        break;
      case 2:
        text.erase(at, below(8));
        break;
      default:
        text[at] = "0123456789e.-[]{}\",:"[below(20)];
    }
  }
  return text;
}

/// What the loop does with a message, but for files and clock.
void obey(Session& session, const Message& message) {
  if (message.wish == Wish::set) set_key(session, std::size_t(message.key), message.value);
  if (message.wish == Wish::grab) grab(session, {message.body, message.vertex, message.place});
  if (message.wish == Wish::move && session.grab)
    grab(session, {session.grab->body, session.grab->vertex, message.place});
  if (message.wish == Wish::release) release(session);
  if (message.wish == Wish::place) place_handle(session, std::size_t(message.obstacle), message.place);
}

}  // namespace

TEST_CASE("wishes are understood") {
  const auto set = decode_message(good[2]);
  REQUIRE(set);
  CHECK(set->wish == Wish::set);
  CHECK(set->key == 3);
  CHECK(set->value == 0.25);
  const auto grabbed = decode_message(good[3]);
  REQUIRE(grabbed);
  CHECK(grabbed->vertex == 17);
  CHECK(grabbed->place == Vector3d(0.1, 2, -0.3));
  for (const std::string& text : good) CHECK(decode_message(text));
}

TEST_CASE("what is no wish is refused, a path above all") {
  for (const char* text : {"",
                           "{}",
                           "[]",
                           "null",
                           "7",
                           "\"play\"",
                           "{\"wish\":7}",
                           "{\"wish\":\"fly\"}",
                           "{\"wish\":\"play\"",
                           "{\"wish\":\"play\"} x",
                           "{\"wish\":\"save\",\"path\":\"/etc/passwd\"}",
                           "{\"wish\":\"save\",\"name\":\"x\"}",
                           "{\"wish\":\"set\",\"key\":1}",
                           "{\"wish\":\"set\",\"key\":-1,\"value\":1}",
                           "{\"wish\":\"set\",\"key\":1.5,\"value\":1}",
                           "{\"wish\":\"set\",\"key\":99999999999999,\"value\":1}",
                           "{\"wish\":\"set\",\"key\":1,\"value\":\"1\"}",
                           "{\"wish\":\"set\",\"key\":1,\"value\":1e999}",
                           "{\"wish\":\"grab\",\"body\":0,\"vertex\":1,\"place\":[1,2]}",
                           "{\"wish\":\"grab\",\"body\":0,\"vertex\":1,\"place\":[1,2,null]}",
                           "{\"wish\":\"slower\",\"value\":0}",
                           "{\"wish\":\"slower\",\"value\":1e9}",
                           "{\"wish\":\"show\",\"frame\":true}",
                           "{\"wish\":\"move\",\"place\":{}}",
                           "{\"wish\":\"cells\",\"body\":0}",
                           "{\"wish\":\"cells\",\"body\":0,\"cells\":0}",
                           "{\"wish\":\"cells\",\"body\":0,\"cells\":2.5}",
                           "{\"wish\":\"cells\",\"body\":-1,\"cells\":20}",
                           "{\"wish\":\"cells\",\"body\":0,\"cells\":20001}"})
    CHECK_FALSE(decode_message(text));
  CHECK_FALSE(decode_message("{\"wish\":\"play\"" + std::string(600, ' ') + "}"));
  CHECK_FALSE(decode_message(std::string(500, '[')));
}

TEST_CASE("a hundred thousand random messages do no harm") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  std::mt19937 random(7);
  int understood = 0;
  for (int i = 0; i < 100000; ++i) {
    const auto message = decode_message(random_message(random));
    if (!message) continue;
    ++understood;
    obey(session, *message);
    if (understood % 400 == 0) step(session);
  }
  CHECK(understood > 1000);
  CHECK(understood < 60000);
  CHECK(session.state.positions.allFinite());
}

TEST_CASE("the page is told of every body, obstacle and key") {
  const TemporaryFolder folder;
  const Session session(live_scene(folder));
  const nlohmann::json hello = nlohmann::json::parse(hello_text(session, 100));
  CHECK(hello["bodies"].size() == 1);
  CHECK(hello["bodies"][0]["hexes"] == 8);
  CHECK(hello["bodies"][0]["cells"] == true);
  CHECK(hello["most_cells"] == most_live_cells);
  CHECK(hello["obstacles"][0]["plane"] == true);
  REQUIRE(hello["keys"].size() == session.keys.size());
  CHECK(hello["keys"][0]["path"] == "body.block.limit.stretch");
  CHECK(hello["values"][0] == 0.1);
  CHECK(nlohmann::json::parse(told_text("note", "bad \xff bytes"))["type"] == "note");
}

TEST_CASE("what all see is changed by who steers alone") {
  for (const Wish wish :
       {Wish::play, Wish::set, Wish::grab, Wish::restart, Wish::save, Wish::show, Wish::rewind, Wish::cells})
    CHECK(needs_steering(wish));
  for (const Wish wish : {Wish::seen, Wish::steer, Wish::lines}) CHECK_FALSE(needs_steering(wish));
}
