// Which OpenVDB files are read, and what is said of the others.
#include "embedding/maps/vdb_grid.h"

#include <limits>

#include "tests/embedding/meshes.h"
#include "tests/embedding/vdb_file.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"

using namespace umax;
using namespace umax::testing;
using umax::test::contains;
using umax::test::Failure;
using umax::test::VdbContent;

namespace {

Failure refusal_of_grid(const std::filesystem::path& path, const std::string& name = "") {
  return test::failure_of([&] { VdbGrid(path, name, VdbGrid::Kind::number); });
}

}  // namespace

TEST_CASE("a grid that cannot be meant is refused with what there is") {
  const auto one = [](const Vector3d&) { return 1.0; };
  const VdbContent soft{.name = "soft", .number = one}, hard{.name = "hard", .number = one},
      flow{.name = "flow", .direction = [](const Vector3d& p) { return p; }}, ids{.name = "ids", .is_integer = true};
  const auto two = vdb_file("two.vdb", {soft, hard, flow, ids});
  CHECK(VdbGrid(two, "hard", VdbGrid::Kind::number).name() == "hard");
  CHECK(VdbGrid(two, "", VdbGrid::Kind::direction).name() == "flow");

  const Failure several = refusal_of_grid(two), missing = refusal_of_grid(two, "harder"),
                vector = refusal_of_grid(two, "flow"), integer = refusal_of_grid(two, "ids"),
                none = refusal_of_grid(vdb_file("flow.vdb", {flow, ids}));
  for (const Failure& refusal : {several, missing, vector, integer, none}) CHECK(refusal.code == 65);
  CHECK(contains(several.message, "has 2 float grids: which one is meant?; name one: \"hard\", \"soft\""));
  CHECK(contains(missing.message, "has no grid of this name, got \"harder\"; its float grids are \"hard\", \"soft\""));
  CHECK(contains(vector.message, "the grid \"flow\" is not of type float, got vec3s"));
  CHECK(contains(integer.message, "the grid \"ids\" is not of type float, got int32"));
  CHECK(contains(none.message,
                 "has no float grid; write one of this type; the file has \"flow\" (vec3s), \"ids\" (int32)"));

  VdbContent empty = soft, distances = soft, negative = soft, broken = soft;
  empty.last = {-11, -11, -11};
  distances.is_level_set = true;
  negative.number = [](const Vector3d& p) { return p.x() > 0.48 ? -1.0 : 1.0; };
  broken.number = [](const Vector3d& p) { return p.norm() < 0.01 ? std::numeric_limits<double>::quiet_NaN() : 1.0; };
  CHECK(contains(refusal_of_grid(vdb_file("empty.vdb", {empty})).message, "the grid \"soft\" is empty"));
  CHECK(
      contains(refusal_of_grid(vdb_file("distances.vdb", {distances})).message, "is a level set: it holds distances"));
  CHECK(contains(refusal_of_grid(vdb_file("negative.vdb", {negative})).message,
                 "has 441 active values that are not finite or negative, got first -1 at voxel [10, -10, -10]"));
  CHECK(contains(refusal_of_grid(vdb_file("broken.vdb", {broken})).message,
                 "has 1 active value that is not finite or negative"));
}

TEST_CASE("a damaged OpenVDB file is refused, wherever it ends") {
  const auto path = vdb_file("whole.vdb", {{.number = [](const Vector3d& p) { return 1 + p.squaredNorm(); }}});
  const std::string whole = file_text(path);
  REQUIRE(whole.size() > 1000);
  for (const double share : {0.0005, 0.01, 0.03, 0.1, 0.3, 0.6, 0.9, 0.999}) {
    const auto size = std::size_t(share * double(whole.size()));
    CAPTURE(size);
    const auto code = refusal_of_grid(write_file("part.vdb", whole.substr(0, size))).code;
    CHECK(code == 65);
  }
  CHECK(refusal_of_grid(write_file("garbage.vdb", std::string(5000, 'x'))).code == 65);
  CHECK(refusal_of_grid("no/such.vdb").code == 66);
}
