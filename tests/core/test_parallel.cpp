// Loops that are begun in order (core/base/parallel.h).
#include "core/base/parallel.h"

#include <tbb/global_control.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "tests/support/catch.h"

using namespace umax;

namespace {

thread_local bool is_inside = false;

}  // namespace

TEST_CASE("what is begun in order is done once each, on one thread in that order") {
  const Eigen::Index count = GENERATE(0, 1, 2, 100);
  CAPTURE(count);
  std::vector<int> times(std::size_t(count), 0);
  parallel_in_order(count, [&](Eigen::Index i) { ++times[std::size_t(i)]; });
  CHECK(times == std::vector<int>(std::size_t(count), 1));

  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<Eigen::Index> begun, expected;
  for (Eigen::Index i = 0; i < count; ++i) expected.push_back(i);
  parallel_in_order(count, [&](Eigen::Index i) { begun.push_back(i); });
  CHECK(begun == expected);
}

TEST_CASE("what waits inside a body that was begun in order takes no further body meanwhile") {
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 4);
  std::atomic<int> nested{0};
  std::atomic<std::int64_t> sum{0};
  parallel_in_order(64, [&](Eigen::Index) {
    if (is_inside) ++nested;
    is_inside = true;
    parallel_blocks(64, 1, [&](Eigen::Index begin, Eigen::Index) {
      std::int64_t own = 0;
      for (volatile int i = 0; i < 20000; i = i + 1) own += begin;
      sum += own;
    });
    is_inside = false;
  });
  CHECK(nested == 0);
  CHECK(sum == std::int64_t(64) * 20000 * 63 * 32);
}

TEST_CASE("a failure of what is begun in order reaches whoever began it") {
  CHECK_THROWS_AS(parallel_in_order(10,
                                    [](Eigen::Index i) {
                                      if (i == 3) throw std::runtime_error("3");
                                    }),
                  std::runtime_error);
}
