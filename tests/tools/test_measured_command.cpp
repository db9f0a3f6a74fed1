// The bench measures commands and not itself.
#include <cstdio>

#include "tests/support/catch.h"
#include "tests/tools/program.h"
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

TEST_CASE("two programs are measured by what their steps say that they took") {
  const TemporaryFolder folder;
  const auto script = folder / "umax";  // another umax, each of whose steps takes 10 s
  make_file(script,
            "#!/bin/sh\nmkdir -p \"$4\" && printf 'limits_active,status,contacts,wall_ms\\n0,converged,0,1\\n"
            "0,converged,1,15e3\\n1,converged,0,5e3\\n' > \"$4/steps.csv\"\n");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  const ProcessResult result =
      run_process({UMAX_BENCH, "--against", script.string(), "--only", "figure", "--turns", "1"});
  CAPTURE(result.output, result.messages);
  CHECK(result.exit_code == 0);
  CHECK(result.output.find("and 1e+04 ms)") != std::string::npos);
  CHECK(result.output.find("met    figure, 365 hexes: active step") != std::string::npos);
  const ProcessResult none = run_process({UMAX_BENCH, "--against", (folder / "none").string()});
  CHECK(none.exit_code == 2);
  CHECK(none.messages.find("there is no such program") != std::string::npos);
}

TEST_CASE("a measured command that fails hands on its exit code") {
  CHECK(run_process({UMAX_BENCH, "--measure", "false"}).exit_code == 1);
  CHECK(run_process({UMAX_BENCH, "--measure", "no-such-program"}).exit_code == 127);
  CHECK(run_process({UMAX_BENCH, "--measure", "sh", "-c", "kill -TERM $$"}).exit_code == 128 + 15);
}
