// The bench measures commands and not itself.
#include <cstdio>

#include "tests/support/catch.h"
#include "tools/system/subprocess.h"

using namespace umax;

TEST_CASE("the peak memory of a command is its own, however much the caller holds") {
  const std::vector<char> ours(std::size_t(300) << 20, 1);
  const auto peak_of = [](const std::vector<std::string>& command) {
    std::vector<std::string> words{UMAX_BENCH, "--measure"};
    words.insert(words.end(), command.begin(), command.end());
    const ProcessResult result = run_process(words);
    REQUIRE(result.exit_code == 0);
    double seconds = -1, cpu_seconds = -1, bytes = -1;
    REQUIRE(std::sscanf(result.output.c_str(), "%lf %lf %lf", &seconds, &cpu_seconds, &bytes) == 3);
    CHECK(seconds > 0);
    CHECK(cpu_seconds >= 0);
    return bytes;
  };
  REQUIRE(ours.back() == 1);
  CHECK(peak_of({"true"}) < 100e6);
  const double large = peak_of({"dd", "if=/dev/zero", "of=/dev/null", "bs=150M", "count=1"});
  CHECK(large > 150e6);
  CHECK(large < 250e6);
}

TEST_CASE("a measured command that fails hands on its exit code") {
  CHECK(run_process({UMAX_BENCH, "--measure", "false"}).exit_code == 1);
  CHECK(run_process({UMAX_BENCH, "--measure", "no-such-program"}).exit_code == 127);
  CHECK(run_process({UMAX_BENCH, "--measure", "sh", "-c", "kill -TERM $$"}).exit_code == 128 + 15);
}
