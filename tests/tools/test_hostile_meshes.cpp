// Mesh files that crash the library that reads them, as a user of the program sees it, built and installed.
#include "tests/embedding/mesh_files.h"
#include "tests/support/catch.h"
#include "tests/support/replaced.h"
#include "tests/tools/program.h"

using namespace umax;
using umax::test::replaced;
namespace fs = std::filesystem;

namespace {

/// Two objects of one number.
std::string colliding_fbx() {
  std::string text = replaced(testing::fbx_document, "Model: 200", "Model: 100");
  text = replaced(text, "\"OO\",200,0", "\"OO\",100,0");
  return replaced(text, "\"OO\",100,200", "\"OO\",100,100");
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("a mesh that crashes its reader ends the program with 65, its name and a remedy, and leaves nothing") {
  const TemporaryFolder folder;
  make_file(folder / "bad.fbx", colliding_fbx());
  for (const Words& words : {Words{"inspect"}, Words{"drop", "-o", (folder / "out").string()}}) {
    const ProcessResult result = umax_program(words + Words{(folder / "bad.fbx").string()});
    CAPTURE(result.messages);
    CHECK(result.exit_code == 65);
    CHECK(says(result.messages, "umax: error: "));
    CHECK(says(result.messages, "bad.fbx: "));
    CHECK(says(result.messages, "export"));
    CHECK(!fs::exists(folder / "out"));
  }
}

TEST_CASE("an installed program finds its helper in ../libexec/umax, and without one it says where it looked") {
  const TemporaryFolder folder;
  const fs::path built = UMAX_PROGRAM, installed = folder / "bin/umax", helper = folder / "libexec/umax/umax-import";
  fs::create_directories(installed.parent_path());
  fs::create_directories(helper.parent_path());
  fs::create_hard_link(built, installed);
  make_file(folder / "two.fbx", testing::fbx_document);
  const Words call{installed.string(), "inspect", (folder / "two.fbx").string(), "--height", "1 m", "--up", "y"};

  const ProcessResult without = run_process(call);
  CAPTURE(without.messages);
  CHECK(without.exit_code == 69);
  CHECK(says(without.messages, "umax-import"));
  CHECK(says(without.messages, helper.string()));
  CHECK(says(without.messages, "UMAX_IMPORT"));

  fs::create_hard_link(built.parent_path() / "umax-import", helper);
  const ProcessResult with = run_process(call);
  CAPTURE(with.messages);
  CHECK(with.exit_code == 0);
  CHECK(says(with.output, "5 vertices, 3 triangles"));
  // formats that need no helper are read without one
  fs::remove(helper);
  make_file(folder / "two.off", testing::off_document);
  CHECK(run_process({installed.string(), "inspect", (folder / "two.off").string(), "--height", "1 m"}).exit_code == 0);
}
