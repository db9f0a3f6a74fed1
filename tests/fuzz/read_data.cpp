// Data beside scenes: states, pulls and measurements.
#include <cmath>

#include "core/files/sha256.h"
#include "tests/fuzz/fuzz_target.h"
#include "tools/fit/measurements.h"
#include "tools/setup/pull_file.h"
#include "tools/setup/state_file.h"

namespace umax::fuzz {
namespace {

Model two_hexes() {
  Body body;
  body.name = "bar";
  body.lattice = make_box_lattice({2, 1, 1}, {0, 1, 0}, {0.1, 0.1, 0.1});
  return make_model({body}, {});
}

/// Written, read and written again, it stays the same bytes.
void check_state(const std::string& file) {
  accepts([&] {
    Digest digest, again;
    const std::string bytes = encode_state(decode_state(file, "a.state", digest), digest);
    require(encode_state(decode_state(bytes, "a.state", again), again) == bytes, "a state reads back as itself");
  });
}

void check_pulls(const std::string& file) {
  static const Model model = two_hexes();
  accepts([&] {
    const std::string bytes = encode_pulls(decode_pulls(file, "a.pulls", model), model);
    require(encode_pulls(decode_pulls(bytes, "a.pulls", model), model) == bytes, "pulls read back as themselves");
  });
}

}  // namespace

void read_state(std::string_view bytes) {
  const std::string body(bytes);
  const bool are_pulls = bytes.starts_with("UMAXPULL");
  are_pulls ? check_pulls(body) : check_state(body);
  // with a checksum that fits, as no chance would make it
  const std::string whole = body + sha256_hex(body);
  are_pulls ? check_pulls(whole) : check_state(whole);
}

void read_measurements(std::string_view bytes) {
  for (const TestKind test : {TestKind::uniaxial, TestKind::compression, TestKind::shear})
    accepts([&] {
      const Measurements measurements =
          parse_measurements(bytes, "m.csv", {.test = test, .length = 0.05, .area = 25e-6});
      require(measurements.points.size() >= 3, "there are as many points as a fit needs");
      for (const MeasuredPoint& point : measurements.points) {
        require(std::isfinite(point.stretch) && std::isfinite(point.stress), "points are finite");
        require(!std::isinf(point.lateral_stretch), "lateral stretches are finite or unknown");
      }
    });
}

}  // namespace umax::fuzz
