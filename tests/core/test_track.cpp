#include "core/base/track.h"
#include "core/base/types.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

Track<double> two_keys(Interpolation interpolation) {
  Track<double> track;
  track.times = {1, 3};
  track.values = {10, 20};
  track.interpolation = interpolation;
  return track;
}

}  // namespace

TEST_CASE("a constant track has its value at all times") {
  const Track<double> track = 7.0;
  CHECK(track.is_constant());
  for (const double time : {-1e9, 0.0, 0.5, 1e9}) CHECK(track.at(time) == 7.0);
}

TEST_CASE("a track passes through its keys and holds outside them") {
  const auto interpolation = GENERATE(Interpolation::linear, Interpolation::smooth);
  const Track<double> track = two_keys(interpolation);
  CHECK(track.at(-5) == 10);
  CHECK(track.at(1) == 10);
  CHECK(track.at(3) == 20);
  CHECK(track.at(99) == 20);
  CHECK(track.at(2) == 15);
}

TEST_CASE("linear keys interpolate in proportion, smooth keys ease with zero slope at both ends") {
  CHECK(two_keys(Interpolation::linear).at(1.5) == Approx(12.5));
  const Track<double> smooth = two_keys(Interpolation::smooth);
  CHECK(smooth.at(1.5) == Approx(10 + 10 * (3 * 0.0625 - 2 * 0.015625)));
  // a slope of zero: the value moves by the square of the time
  for (const double end : {1.0, 3.0}) {
    const double inward = end == 1.0 ? 1 : -1;
    const double near = std::abs(smooth.at(end + inward * 1e-4) - smooth.at(end));
    const double nearer = std::abs(smooth.at(end + inward * 0.5e-4) - smooth.at(end));
    CHECK(near / nearer == Approx(4).epsilon(1e-3));
  }
}

TEST_CASE("keys that are held have the value of the last one until the next") {
  Track<double> track = two_keys(Interpolation::hold);
  CHECK(track.at(0) == 10);
  CHECK(track.at(1) == 10);
  CHECK(track.at(std::nextafter(3.0, 0.0)) == 10);
  CHECK(track.at(3) == 20);
  CHECK(track.at(99) == 20);
}

TEST_CASE("a track of vectors interpolates each component") {
  Track<Vector3d> track;
  track.times = {0, 2, 4};
  track.values = {Vector3d(0, 0, 0), Vector3d(2, 4, 6), Vector3d(2, 0, 6)};
  CHECK(track.at(1) == Vector3d(1, 2, 3));
  CHECK(track.at(3) == Vector3d(2, 2, 6));
}
