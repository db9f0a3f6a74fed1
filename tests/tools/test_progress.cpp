#include <algorithm>
#include <cstdio>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tools/system/progress.h"

using namespace umax;

namespace {

const ProgressLine line{
    .stage = "render", .frame = 30, .done = 30, .total = 120, .elapsed = 15, .rate = 2, .detail = "12 limits"};

/// What a Progress writes to a stream that is no terminal.
std::string written(ProgressMode mode, bool quiet) {
  const TemporaryFolder folder;
  const auto path = folder / "out.txt";
  std::FILE* stream = std::fopen(path.c_str(), "w");
  {
    Progress progress(stream, mode, quiet);
    progress.begin("simulate", 3);
    for (int frame = 1; frame <= 3; ++frame) progress.frame_done(frame, "a \"quoted\" detail");
    progress.end();
    progress.note("done");
  }
  std::fclose(stream);
  return file_text(path);
}

long num_lines(const std::string& text) {
  return std::count(text.begin(), text.end(), '\n');
}

}  // namespace

TEST_CASE("durations read as clocks do") {
  CHECK(format_duration(0) == "0:00");
  CHECK(format_duration(7.4) == "0:07");
  CHECK(format_duration(59.7) == "1:00");
  CHECK(format_duration(3723) == "1:02:03");
  CHECK(format_duration(-1) == "?");
}

TEST_CASE("a bar fits the terminal and shows frame, rate and time left") {
  for (const int width : {20, 40, 60, 80, 200}) CHECK(int(format_bar(line, width).size()) <= width);
  const std::string bar = format_bar(line, 100);
  CHECK(bar.find("30/120") != std::string::npos);
  CHECK(bar.find("2.0 frames/s") != std::string::npos);
  CHECK(bar.find("0:45 left") != std::string::npos);
  CHECK(bar.find("[##########......") != std::string::npos);
}

TEST_CASE("slow frames are given in seconds per frame") {
  ProgressLine slow = line;
  slow.rate = 0.25;
  CHECK(format_plain(slow).find("4.0 s/frame") != std::string::npos);
}

TEST_CASE("off a terminal there is one line per frame and no carriage return") {
  const std::string text = written(ProgressMode::automatic, false);
  CHECK(text.find('\r') == std::string::npos);
  CHECK(text.find('\x1b') == std::string::npos);
  CHECK(num_lines(text) == 4);
  CHECK(text.find("simulate frame 2 (2/3)") != std::string::npos);
}

TEST_CASE("quiet says nothing") {
  CHECK(written(ProgressMode::automatic, true).empty());
}

TEST_CASE("json progress is one object per line") {
  const std::string text = written(ProgressMode::json, false);
  CHECK(num_lines(text) == 6);
  CHECK(text.find(R"("event":"frame","stage":"simulate","frame":2,"done":2,"total":3)") != std::string::npos);
  CHECK(text.find(R"("detail":"a \"quoted\" detail")") != std::string::npos);
  for (std::size_t start = 0; start < text.size(); start = text.find('\n', start) + 1) {
    CHECK(text[start] == '{');
    CHECK(text[text.find('\n', start) - 1] == '}');
  }
}
