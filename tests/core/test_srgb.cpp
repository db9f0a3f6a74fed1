#include "core/base/srgb.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

/// The largest |encode(decode(x)) - x| over the 8-bit codes.
template <class Real>
Real worst_round_trip() {
  Real worst = 0;
  for (int code = 0; code < 256; ++code) {
    const Real encoded = Real(code) / 255;
    worst = std::max(worst, std::abs(srgb_from_linear(linear_from_srgb(encoded)) - encoded));
  }
  return worst;
}

}  // namespace

TEST_CASE("the sRGB curve has the values of IEC 61966-2-1, in float and in double", "[srgb]") {
  CHECK(linear_from_srgb(0.5) == Approx(0.21404114048223255).epsilon(1e-15));
  CHECK(linear_from_srgb(0.5f) == Approx(0.21404114).epsilon(1e-6));
  CHECK(linear_from_srgb(0.04) == 0.04 / 12.92);
  CHECK(linear_from_srgb(1.0) == Approx(1).epsilon(1e-15));
  CHECK(srgb_from_linear(-0.1) == Approx(-1.292));
  // the standard's two pieces meet within 1e-7 at the rounded threshold
  CHECK(worst_round_trip<double>() < 1e-7);
  CHECK(worst_round_trip<float>() < 1e-6f);
}
