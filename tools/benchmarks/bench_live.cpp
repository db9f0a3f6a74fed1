// umax live with a client that draws at once: how many steps a second, how soon a slider is seen, how long pictures are.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <fstream>
#include <future>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "scenes/scene_file.h"
#include "tests/support/raw_client.h"
#include "tools/benchmarks/bench.h"
#include "tools/live/server.h"
#include "tools/system/scratch_folder.h"
#include "tools/system/seconds_since.h"

namespace umax {
namespace {

using Clock = std::chrono::steady_clock;

double mean(const std::vector<double>& values) {
  return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[std::size_t(share * double(values.size() - 1))];
}

Scene scene_with(int cells) {
  std::vector<Override> overrides;
  if (cells != 365) overrides.push_back(parse_override(fmt::format("body.figure.cage.cells={}", cells)));
  return load_scene("figure", overrides);
}

/// A served session, and a client that has its cookie.
class LiveBench {
 public:
  LiveBench(int cells, double slower)
      : session_(scene_with(cells)), recording_(scratch_.path() / "live", ExistingFolder::refuse, 1000) {
    server_ = std::thread([this, slower] {
      serve(session_, recording_,
            {.on_address =
                 [this](const std::string& address, bool is_first) {
                   if (is_first) address_.set_value(address);
                 },
             .on_line = [](const std::string&) {},
             .ends = [this] { return ends_.load(); },
             .slower = slower});
    });
    const std::string address = address_.get_future().get();
    const std::size_t start = std::string("http://").size(), end = address.find("/?");
    const std::string host = address.substr(start, end - start);
    const int port = std::stoi(host.substr(host.find(':') + 1));
    test::RawClient visitor(port);
    const std::string answer = visitor.get(address.substr(end), "Host: " + host + "\r\n");
    const std::size_t at = answer.find("Set-Cookie: ") + 12;
    const std::string cookie = answer.substr(at, answer.find(';', at) - at);
    client = std::make_unique<test::RawClient>(port);
    if (!client->upgrade("Host: " + host + "\r\nOrigin: http://" + host + "\r\nCookie: " + cookie + "\r\n"))
      throw std::runtime_error("the server let the client not in");
  }
  ~LiveBench() { end(); }

  /// The session, once nothing works on it any more.
  const Session& end() {
    ends_ = true;
    if (server_.joinable()) server_.join();
    return session_;
  }

  /// The next picture, acknowledged; texts on the way are told.
  FrameHeader picture(std::size_t& bytes, const std::function<void(const std::string&)>& told = {}) {
    while (true) {
      const auto frame = client->hear();
      if (!frame || frame->opcode == 8) throw std::runtime_error("the server has gone");
      if (frame->opcode == 1 && told) told(frame->bytes);
      if (frame->opcode != 2) continue;
      FrameHeader header;
      std::memcpy(&header, frame->bytes.data(), sizeof header);
      client->say(fmt::format("{{\"wish\":\"seen\",\"frame\":{}}}", header.number));
      bytes = frame->bytes.size();
      return header;
    }
  }

  std::unique_ptr<test::RawClient> client;

 private:
  const ScratchFolder scratch_;
  Session session_;
  Recording recording_;
  std::promise<std::string> address_;
  std::atomic<bool> ends_ = false;
  std::thread server_;
};

/// Falls and lies for this many seconds of its own time, as fast as it goes.
BenchRows speed_rows(const std::string& what, int cells, double least, double longest_ms, bool tell_bytes) {
  LiveBench bench(cells, 0);
  bench.client->say("{\"wish\":\"play\"}");
  std::vector<double> sizes;
  std::optional<FrameHeader> first;
  FrameHeader last;
  Clock::time_point start, end;
  while (last.time < 4) {
    std::size_t bytes = 0;
    last = bench.picture(bytes);
    end = Clock::now();
    if (last.contacts == 0) continue;
    if (!first) first = last, start = end;
    sizes.push_back(double(bytes));
  }
  std::vector<double> ms;
  for (const StepRow& row : bench.end().rows)
    if (row.report.contacts > 0) ms.push_back(row.wall_ms);
  const double seconds = std::chrono::duration<double>(end - start).count();
  const double rate = double(last.step - first->step) / seconds;
  BenchRows rows{{what + ": steps a second in contact, one client", fmt::format("{:.1f}", rate),
                  fmt::format(">= {:.0f}", least), rate >= least},
                 at_most(what + ": 95 % of steps", percentile(ms, 0.95), longest_ms, "ms",
                         fmt::format("mean {:.1f} ms", mean(ms)))};
  if (tell_bytes)
    rows.push_back(at_most(what + ": bytes a picture, mean", mean(sizes), 12000, "",
                           fmt::format("longest {:.0f}; aim 6000", percentile(sizes, 1))));
  return rows;
}

/// At real time, lying on the ground: from a slider to the first picture of a step that has its value.
BenchRows latency_rows() {
  LiveBench bench(365, 1);
  bench.client->say("{\"wish\":\"play\"}");
  std::size_t bytes = 0;
  while (bench.picture(bytes).time < 1) {
  }
  std::vector<double> ms;
  for (int i = 0; i < 60; ++i) {
    const std::string value = fmt::format("{}", 300000 + 1000 * i);
    for (int wait = 0; wait < 3 + i % 5; ++wait) bench.picture(bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(i * 7 % 17));
    // the key of stiffness is the one behind the limit; its value is told behind the first picture that has it
    const auto start = Clock::now();
    bench.client->say("{\"wish\":\"set\",\"key\":1,\"value\":" + value + "}");
    double shown = 0;
    while (shown == 0)
      bench.picture(bytes, [&](const std::string& text) {
        if (text.find(value) != std::string::npos) shown = 1000 * seconds_since(start);
      });
    ms.push_back(shown);
  }
  return {at_most("live: slider to the first changed picture on the wire, 95 %", percentile(ms, 0.95), 50, "ms",
                  fmt::format("mean {:.1f} ms; aim 25", mean(ms)))};
}

/// [MiB] that this process has in memory.
double resident() {
  long long pages = 0, shown = 0;
  std::ifstream("/proc/self/statm") >> pages >> shown;
  return double(shown) * double(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

/// As many steps as these minutes at real time have, as fast as they go, a limit turned twice a second.
BenchRow memory_row(const std::string& what, int cells, int minutes_before, int minutes) {
  constexpr std::uint32_t steps_a_minute = 60 * 60;
  LiveBench bench(cells, 0);
  bench.client->say("{\"wish\":\"play\"}");
  double before = 0;
  std::uint32_t turned = 0;
  for (FrameHeader last; last.step < std::uint32_t(minutes) * steps_a_minute;) {
    std::size_t bytes = 0;
    last = bench.picture(bytes);
    if (before == 0 && last.step > std::uint32_t(minutes_before) * steps_a_minute) before = resident();
    if (last.step < turned + 30) continue;
    turned = last.step;
    bench.client->say(fmt::format("{{\"wish\":\"set\",\"key\":0,\"value\":0.{}}}", 15 + turned % 7));
  }
  return at_most(fmt::format("{}: memory after {} minutes, of that after {}", what, minutes, minutes_before),
                 resident() / before, 1.05, "", fmt::format("{:.0f} MiB", resident()));
}

BenchRows memory_rows() {
  return {memory_row("live: figure, 365 hexes", 365, 3, 30)};
}

BenchRows live_rows() {
  BenchRows rows = speed_rows("live: figure, 365 hexes", 365, 60, 30, true);
  for (BenchRow& row : latency_rows()) rows.push_back(row);
  for (BenchRow& row : speed_rows("live: figure, 2,000 hexes", 2000, 40, 60, false)) rows.push_back(row);
  rows.push_back(memory_row("live: figure, 60 hexes", 60, 1, 4));
  return rows;
}

}  // namespace

std::vector<Benchmark> live_benchmarks() {
  return {{.name = "live", .run = live_rows}, {.name = "live-memory", .slow = true, .run = memory_rows}};
}

}  // namespace umax
