#include "core/base/parallel.h"

#include <algorithm>
#include <atomic>
#ifdef __SANITIZE_THREAD__
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#else
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace umax {
namespace {

#ifdef __SANITIZE_THREAD__

/// The thread sanitizer does not see through TBB's scheduler: threads that it knows from begin to end, which share nothing.
template <class Run>
void run_blocks(Eigen::Index num_blocks, const Run& run) {
  constexpr Eigen::Index most_threads = 4;
  const Eigen::Index num_threads = std::min(num_blocks, most_threads);
  std::exception_ptr failure;
  std::mutex mutex;
  std::vector<std::thread> threads;
  for (Eigen::Index t = 0; t < num_threads; ++t)
    threads.emplace_back([&, t] {
      try {
        for (Eigen::Index b = t; b < num_blocks; b += num_threads) run(b);
      } catch (...) {
        const std::lock_guard lock(mutex);
        failure = std::current_exception();
      }
    });
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

template <class Run>
void run_alone(const Run& run) {
  run();
}

#else

template <class Run>
void run_blocks(Eigen::Index num_blocks, const Run& run) {
  tbb::parallel_for(Eigen::Index(0), num_blocks, run);
}

template <class Run>
void run_alone(const Run& run) {
  tbb::this_task_arena::isolate(run);
}

#endif

}  // namespace

void parallel_blocks(Eigen::Index count, Eigen::Index grain,
                     const std::function<void(Eigen::Index, Eigen::Index)>& body) {
  const Eigen::Index num_blocks = (count + grain - 1) / grain;
  if (num_blocks <= 1) {
    if (count > 0) body(0, count);
    return;
  }
  run_blocks(num_blocks, [&](Eigen::Index b) { body(b * grain, std::min(count, (b + 1) * grain)); });
}

void parallel_in_order(Eigen::Index count, const std::function<void(Eigen::Index)>& body) {
  if (count <= 1) {
    if (count > 0) body(0);
    return;
  }
  std::atomic<Eigen::Index> next{0};
  run_blocks(count, [&](Eigen::Index) {
    const Eigen::Index i = next++;
    run_alone([&] { body(i); });
  });
}

}  // namespace umax
