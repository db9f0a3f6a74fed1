// The server over real sockets: who is let in, what it withstands, what it sends.
#include "tools/live/server.h"

#include <atomic>
#include <cstring>
#include <future>
#include <random>
#include <thread>

#include "tests/live/live_scenes.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/support/raw_client.h"
#include "tools/live/access.h"

using namespace umax;
using namespace umax::test;

namespace {

/// A session of a block that is served until the test ends.
class Served {
 public:
  Served() : session(live_scene(folder)), recording(folder / "live", ExistingFolder::refuse, 100) {
    thread_ = std::thread([this] {
      try {
        serve(session, recording,
              {.on_address =
                   [this](const std::string& address, bool is_first) {
                     const std::lock_guard lock(mutex_);
                     address_ = address;
                     if (is_first) listens_.set_value();
                   },
               .on_line = [](const std::string&) {},
               .ends = [this] { return ends_.load(); },
               .keep = 100});
      } catch (const std::exception& error) {
        failure = error.what();
      }
    });
    listens_.get_future().wait();
    port = std::stoi(address().substr(std::string("http://127.0.0.1:").size()));
    host = "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
    origin = "Origin: http://127.0.0.1:" + std::to_string(port) + "\r\n";
  }
  ~Served() { end(); }

  void end() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::string address() {
    const std::lock_guard lock(mutex_);
    return address_;
  }
  std::string target() { return address().substr(address().find("/?")); }

  /// The Cookie header that the address is exchanged for.
  std::string cookie() {
    RawClient client(port);
    const std::string answer = client.get(target(), host);
    const std::size_t at = answer.find("Set-Cookie: ") + 12;
    return "Cookie: " + answer.substr(at, answer.find(';', at) - at) + "\r\n";
  }

  const TemporaryFolder folder;
  Session session;
  Recording recording;
  int port = 0;
  std::string host, origin, failure;

 private:
  std::atomic<bool> ends_ = false;
  std::promise<void> listens_;
  std::mutex mutex_;
  std::string address_;
  std::thread thread_;
};

FrameHeader header_of(const std::string& bytes) {
  FrameHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  return header;
}

/// The next picture that shows at least this step, each acknowledged.
std::optional<FrameHeader> picture(RawClient& client, std::uint32_t step = 0, int most = 2000) {
  for (int i = 0; i < most; ++i) {
    const auto frame = client.hear();
    if (!frame) return std::nullopt;
    if (frame->opcode != 2) continue;
    const FrameHeader header = header_of(frame->bytes);
    client.acknowledge(frame->bytes);
    if (header.step >= step) return header;
  }
  return std::nullopt;
}

}  // namespace

TEST_CASE("without the cookie there is nothing but a refusal, and the address opens once") {
  Served served;
  const std::string first = served.target();
  for (const char* target :
       {"/", "/page.js", "/body/0", "/live", "/?token=", "/?token=00000000000000000000000000000000"}) {
    RawClient client(served.port);
    CHECK(client.get(target, served.host).starts_with("HTTP/1.1 403"));
  }
  {
    RawClient client(served.port);
    const std::string answer = client.get(first, served.host);
    CHECK(answer.starts_with("HTTP/1.1 200"));
    CHECK(contains(answer, "HttpOnly; SameSite=Strict"));
    CHECK(contains(answer, "Content-Security-Policy: default-src 'none'; script-src 'self'"));
  }
  RawClient again(served.port);
  CHECK(again.get(first, served.host).starts_with("HTTP/1.1 403"));
  CHECK(served.target() != first);
}

TEST_CASE("with the cookie there are the page, its scripts and the meshes, and nothing else") {
  Served served;
  const std::string headers = served.host + served.cookie();
  RawClient client(served.port);
  CHECK(contains(client.get("/", headers), "umax live"));
  CHECK(contains(client.get("/three.min.js", headers), "text/javascript"));
  CHECK(contains(client.get("/OrbitControls.js", headers), "OrbitControls"));
  CHECK(contains(client.get("/body/0", headers), "UMXB"));
  CHECK(contains(client.get("/obstacle/0", headers), "UMXO"));
  for (const char* target : {"/body/1", "/body/-1", "/../etc/passwd", "/page.js/../../x", "/states/0001.state", "//"})
    CHECK(client.get(target, headers).starts_with("HTTP/1.1 404"));
}

TEST_CASE("other hosts, other sites and other methods are refused") {
  Served served;
  const std::string cookie = served.cookie();
  const auto status = [&](const std::string& headers) {
    RawClient client(served.port);
    return client.get("/", headers).substr(9, 3);
  };
  CHECK(status(served.host + cookie) == "200");
  CHECK(status("Host: evil.example\r\n" + cookie) == "403");
  CHECK(status("Host: evil.example:" + std::to_string(served.port) + "\r\n" + cookie) == "403");
  CHECK(status(cookie) == "403");
  CHECK(status(served.host + cookie + "Origin: http://evil.example\r\n") == "403");
  RawClient client(served.port);
  client.send("POST / HTTP/1.1\r\n" + served.host + cookie + "Content-Length: 0\r\n\r\n");
  CHECK(client.answer().starts_with("HTTP/1.1 405"));
  const auto watches = [&](const std::string& headers) {
    RawClient watcher(served.port);
    return watcher.upgrade(headers);
  };
  CHECK(watches(served.host + served.origin + cookie));
  CHECK_FALSE(watches(served.host + cookie));
  CHECK_FALSE(watches(served.host + served.origin));
  CHECK_FALSE(watches("Host: evil.example\r\nOrigin: http://evil.example\r\n" + cookie));
  CHECK_FALSE(watches(served.host + "Origin: http://evil.example\r\n" + cookie));
  CHECK_FALSE(watches(served.host + served.origin + cookie.substr(0, cookie.size() - 3) + "\r\n"));
}

TEST_CASE("it moves when told to, a limit that is changed is said and held, and what is seen is what is computed") {
  Served served;
  RawClient client(served.port);
  REQUIRE(client.upgrade(served.host + served.origin + served.cookie()));
  const std::string hello = client.hear_text("\"hello\"");
  CHECK(contains(hello, "body.block.limit.stretch"));
  REQUIRE(client.say(R"({"wish":"play"})"));
  const auto first = picture(client, 20);
  REQUIRE(first);
  REQUIRE(client.say(R"({"wish":"set","key":0,"value":0.3})"));
  CHECK(contains(client.hear_text("\"values\""), "\"goals\":[0.3,"));
  REQUIRE(client.say(R"({"wish":"pause"})"));
  const auto later = picture(client, first->step);
  REQUIRE(later);
  served.end();
  CHECK(served.failure.empty());
  CHECK(served.session.state.step >= 20);
  CHECK(value_now(served.session, 0) == 0.3);
}

TEST_CASE("another cage is said, the page begins anew with its meshes, and moves on") {
  Served served;
  const std::string cookie = served.cookie();
  RawClient client(served.port), meshes(served.port);
  REQUIRE(client.upgrade(served.host + served.origin + cookie));
  CHECK(contains(client.hear_text("\"hello\""), "\"hexes\":8,"));
  const std::string before = meshes.get("/body/0", served.host + cookie);
  client.say(R"({"wish":"play"})");
  REQUIRE(picture(client, 10));
  client.say(R"({"wish":"cells","body":7,"cells":27})");
  CHECK(contains(client.hear_text("\"error\""), "not there"));
  client.say(R"({"wish":"cells","body":0,"cells":27})");
  const std::string hello = client.hear_text("\"hello\"");
  CHECK_FALSE(contains(hello, "\"hexes\":8,"));
  CHECK(contains(client.hear_text("starts again"), "block has a cage of"));
  const auto anew = picture(client);
  REQUIRE(anew);
  CHECK(anew->step < 10);
  CHECK(picture(client, 10));
  CHECK(meshes.get("/body/0", served.host + cookie).size() > before.size());
  served.end();
  CHECK(served.failure.empty());
  CHECK(served.session.simulation.model.num_hexes() > 8);
}

TEST_CASE("several watch, one steers, and another takes over") {
  Served served;
  const std::string headers = served.host + served.origin + served.cookie();
  RawClient first(served.port), second(served.port);
  REQUIRE(first.upgrade(headers));
  CHECK(contains(first.hear_text("\"role\""), "\"steers\":true"));
  REQUIRE(second.upgrade(headers));
  CHECK(contains(second.hear_text("\"role\""), "\"steers\":false"));
  second.say(R"({"wish":"play"})");
  CHECK(contains(second.hear_text("\"error\""), "steers"));
  second.say(R"({"wish":"steer"})");
  CHECK(contains(second.hear_text("\"steers\":true"), "\"watchers\":2"));
  second.say(R"({"wish":"play"})");
  CHECK(picture(second, 4));
  CHECK(picture(first, 4));
}

TEST_CASE("malformed messages close the connection, and the server goes on") {
  Served served;
  const std::string headers = served.host + served.origin + served.cookie();
  const auto closes = [&](const std::string& bytes, unsigned opcode = 1) {
    RawClient client(served.port);
    REQUIRE(client.upgrade(headers));
    client.say(bytes, opcode);
    return client.is_closed();
  };
  CHECK(closes("{"));
  CHECK(closes(R"({"wish":"save","path":"/tmp/x"})"));
  CHECK(closes(std::string(5000, 'x')));
  CHECK(closes(R"({"wish":"play"})", 2));
  CHECK(closes("\xff\xfe"));
  RawClient client(served.port);
  REQUIRE(client.upgrade(headers));
  CHECK(contains(client.hear_text("\"hello\""), "block"));
}

TEST_CASE("random bytes over many connections do no harm") {
  Served served;
  const std::string headers = served.host + served.origin + served.cookie();
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    RawClient client(served.port);
    REQUIRE(client.is_connected());
    std::string bytes(random() % 200, ' ');
    for (char& c : bytes) c = char(random());
    if (i % 3 == 0) {
      client.send(bytes);
    } else if (client.upgrade(headers)) {
      if (i % 3 == 1)
        client.say(bytes);
      else
        client.send(bytes);
    }
  }
  RawClient client(served.port);
  REQUIRE(client.upgrade(headers));
  CHECK(contains(client.hear_text("\"hello\""), "block"));
  CHECK(served.failure.empty());
}

TEST_CASE("connections are bounded") {
  Served served;
  const std::string headers = served.host + served.origin + served.cookie();
  std::vector<std::unique_ptr<RawClient>> watchers;
  int granted = 0;
  for (int i = 0; i < 12; ++i) {
    watchers.push_back(std::make_unique<RawClient>(served.port));
    granted += watchers.back()->upgrade(headers);
  }
  CHECK(granted == 8);
  std::vector<std::unique_ptr<RawClient>> idle;
  for (int i = 0; i < 100; ++i) idle.push_back(std::make_unique<RawClient>(served.port));
  // the last ones are closed at once
  CHECK(idle.back()->answer().empty());
  watchers.clear();
  idle.clear();
  bool is_back = false;
  for (int i = 0; i < 40 && !is_back; ++i) {
    RawClient client(served.port);
    is_back = client.upgrade(headers);
    if (!is_back) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  CHECK(is_back);
}

TEST_CASE("who draws slowly misses pictures, and those that come are new") {
  Served served;
  RawClient client(served.port);
  REQUIRE(client.upgrade(served.host + served.origin + served.cookie()));
  client.hear_text("\"hello\"");
  RawClient other(served.port);  // which draws all that comes
  REQUIRE(other.upgrade(served.host + served.origin + served.cookie()));
  client.say(R"({"wish":"play"})");
  REQUIRE(picture(other, 40));
  // nothing has been acknowledged: no more than a few are under way
  std::vector<FrameHeader> old;
  client.say(R"({"wish":"lines"})");
  for (auto frame = client.hear(); frame; frame = client.hear()) {
    if (frame->opcode == 2) old.push_back(header_of(frame->bytes));
    if (frame->opcode == 1 && contains(frame->bytes, "\"lines\"")) break;
  }
  CHECK(old.size() <= 3);
  REQUIRE(!old.empty());
  const std::uint32_t last = old.back().step;
  client.say("{\"wish\":\"seen\",\"frame\":" + std::to_string(old.back().number) + "}");
  const auto next = picture(client);
  REQUIRE(next);
  CHECK(next->step > last + 20);
}

TEST_CASE("a port that is taken is said with the remedy") {
  Served served;
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  Recording recording(folder / "live", ExistingFolder::refuse, 10);
  const Failure failure = failure_of([&] {
    serve(session, recording, {.port = served.port, .on_address = {}, .on_line = {}, .ends = [] { return true; }});
  });
  CHECK(failure.code == 69);
  CHECK(contains(failure.remedy, "--port"));
}

TEST_CASE("a page without its libraries is refused before anything is made") {
  ::setenv("UMAX_THREE", "/nowhere", 1);
  const Failure failure = failure_of([] { page_files(); });
  ::unsetenv("UMAX_THREE");
  CHECK(failure.code == 69);
  CHECK(contains(failure.remedy, "libjs-three"));
}
