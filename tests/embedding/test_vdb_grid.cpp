// Which OpenVDB files are read, and what is said of the others.
#include "embedding/maps/vdb_grid.h"

#include <chrono>
#include <limits>
#include <random>

#include "core/base/error.h"
#include "tests/embedding/meshes.h"
#include "tests/embedding/vdb_file.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"

using namespace umax;
using namespace umax::testing;
using umax::test::contains;
using umax::test::Failure;
using umax::test::VdbCompression;
using umax::test::VdbContent;

namespace {

Failure refusal_of_grid(const std::filesystem::path& path, const std::string& name = "") {
  return test::failure_of([&] { VdbGrid(path, name, VdbGrid::Kind::number); });
}

/// Reads a damaged file: it is taken or refused as damaged, soon. Returns whether it was refused.
bool is_refused(const std::string& bytes, VdbGrid::Kind kind) {
  const auto path = write_file("damaged.vdb", bytes);
  const auto start = std::chrono::steady_clock::now();
  bool refused = false;
  try {
    VdbGrid(path, "", kind);
  } catch (const Error& error) {
    refused = true;
    CHECK(error.fault() == Fault::bad_data);
  }
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(5));
  return refused;
}

struct Seed {
  std::string bytes;
  VdbGrid::Kind kind = VdbGrid::Kind::number;
};

/// Small files of numbers and vectors, whole and as halves.
std::vector<Seed> seeds(const std::vector<VdbCompression>& compressions = {VdbCompression::none, VdbCompression::zip,
                                                                           VdbCompression::blosc}) {
  const auto number = [](const Vector3d& p) { return 1 + p.squaredNorm(); };
  const auto direction = [](const Vector3d& p) { return Vector3d(1, p.x(), p.y()); };
  std::vector<Seed> seeds;
  for (const auto compression : compressions)
    for (const bool as_halves : {false, true}) {
      const VdbContent numbers{.number = number, .first = {-3, -3, -3}, .last = {9, 3, 3}, .as_halves = as_halves};
      const VdbContent vectors{
          .direction = direction, .first = {-3, -3, -3}, .last = {9, 3, 3}, .as_halves = as_halves};
      seeds.push_back({file_text(vdb_file("seed.vdb", {numbers}, compression)), VdbGrid::Kind::number});
      seeds.push_back({file_text(vdb_file("seed.vdb", {vectors}, compression)), VdbGrid::Kind::direction});
    }
  return seeds;
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

TEST_CASE("OpenVDB files of every compression are read, and what they promise is found true") {
  for (const Seed& seed : seeds()) CHECK_FALSE(is_refused(seed.bytes, seed.kind));
}

TEST_CASE("a huge count anywhere in an OpenVDB file is refused at once or does no harm") {
  for (const Seed& seed : seeds({VdbCompression::blosc})) {
    const std::size_t front = 680;  // as far as the root of the tree, where compression tells nothing yet
    REQUIRE(seed.bytes.size() > 10 * front);
    int num_refused = 0;
    for (std::size_t at = 0; at < front; ++at) {
      std::string damaged = seed.bytes;
      for (int k = 0; k < 4; ++k) damaged[at + std::size_t(k)] = char(k == 3 ? 0x7f : 0xff);
      CAPTURE(at);
      num_refused += is_refused(damaged, seed.kind);
    }
    CHECK(num_refused > 200);
  }
}

TEST_CASE("OpenVDB files with flipped bits neither crash nor hang") {
  std::mt19937 random(27);
  for (const Seed& seed : seeds())
    for (int trial = 0; trial < 300; ++trial) {
      std::string damaged = seed.bytes;
      const std::size_t at = random() % damaged.size();
      damaged[at] = char(damaged[at] ^ 1 << random() % 8);
      CAPTURE(trial, at);
      is_refused(damaged, seed.kind);
    }
}
