// The README tells the keys that the reader knows.
#include <fstream>
#include <sstream>

#include "scenes/scene_key_table.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

std::string readme() {
  std::ifstream file(std::string(UMAX_SOURCE_DIR) + "/README.md");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("the README's table of scene keys is the reader's own") {
  const std::string text = readme();
  REQUIRE_FALSE(text.empty());
  INFO("paste the output of scene_key_table_markdown() under \"## Scene keys\"");
  CHECK(text.find(scene_key_table_markdown()) != std::string::npos);
}
