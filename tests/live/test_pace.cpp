#include "tools/live/pace.h"

#include "tests/support/catch.h"

using namespace umax;

TEST_CASE("where steps are quick the clock keeps real time") {
  Pace pace{.time_step = 1.0 / 60};
  for (int i = 0; i < 100; ++i) add_step(pace, 0.005);
  CHECK(pace.rate() == Approx(1));
  CHECK_FALSE(pace.is_behind());
}

TEST_CASE("where steps take longer than they last the clock slows smoothly, says so, and comes back") {
  Pace pace{.time_step = 1.0 / 60};
  for (int i = 0; i < 100; ++i) add_step(pace, 0.005);
  double last = pace.period;
  for (int i = 0; i < 300; ++i) {
    add_step(pace, 0.040);
    CHECK(pace.period >= last);
    CHECK(pace.period <= 1.2 * last);
    last = pace.period;
  }
  // it wastes next to nothing of the time that there is
  CHECK(pace.period >= 0.040);
  CHECK(pace.period <= 1.05 * 0.040);
  CHECK(pace.rate() == Approx(1.0 / 60 / pace.period));
  CHECK(pace.is_behind());
  CHECK(pace.time_step == 1.0 / 60);
  for (int i = 0; i < 300; ++i) add_step(pace, 0.005);
  CHECK(pace.rate() == Approx(1).epsilon(0.01));
  CHECK_FALSE(pace.is_behind());
}

TEST_CASE("one long step is no reason to slow down for long") {
  Pace pace{.time_step = 1.0 / 60};
  for (int i = 0; i < 100; ++i) add_step(pace, 0.005);
  add_step(pace, 0.1);
  CHECK(pace.rate() > 0.5);
  for (int i = 0; i < 60; ++i) add_step(pace, 0.005);
  CHECK(pace.rate() > 0.98);
}

TEST_CASE("slower than real time as asked for is not being behind") {
  Pace pace{.time_step = 1.0 / 60, .slower = 4};
  for (int i = 0; i < 100; ++i) add_step(pace, 0.005);
  CHECK(pace.rate() == Approx(0.25));
  CHECK_FALSE(pace.is_behind());
}
