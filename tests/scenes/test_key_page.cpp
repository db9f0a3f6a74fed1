// docs/keys.md tells the keys that the reader knows.
#include <cstdlib>

#include "scenes/scene_key_table.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace umax;

TEST_CASE("the page of scene keys is made from the reader's own table") {
  const std::filesystem::path page = std::filesystem::path(UMAX_SOURCE_DIR) / "docs/keys.md";
  if (const char* update = std::getenv("UMAX_UPDATE_KEYS"); update && std::string(update) == "1") {
    make_file(page, scene_key_page());
    WARN("written: " << page.string());
  }
  INFO("UMAX_UPDATE_KEYS=1 in the environment of this test writes the page anew");
  CHECK((file_text(page) == scene_key_page()));  // in brackets: Catch would print both pages
}
