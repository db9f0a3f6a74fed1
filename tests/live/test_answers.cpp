// What requests are answered, without sockets: test_server.cpp asks the same over real ones.
#include "tools/live/answers.h"

#include "tests/live/live_scenes.h"
#include "tests/support/catch.h"
#include "tools/live/wire.h"

using namespace umax;
using namespace umax::test;

TEST_CASE("a request is answered by who asks, from where, and what for") {
  const TemporaryFolder folder;
  const Simulation simulation = set_up(live_scene(folder));
  const std::map<std::string, std::string> files{{"page.html", "<p>"}, {"page.js", "1"}};
  Access access = new_access();
  const std::string cookie_line = cookie_of(access), cookie = cookie_line.substr(0, cookie_line.find(';')),
                    token = "/?token=" + access.token;
  const auto answer = [&](const Asked& asked) { return answer_to(asked, files, simulation, access); };
  const Asked page{.method = "GET", .target = "/", .host = "127.0.0.1:81", .origin = "", .cookies = cookie};
  const auto changed = [&](auto member, std::string_view value) {
    Asked asked = page;
    asked.*member = value;
    return asked;
  };

  CHECK(answer(page).body == "<p>");
  CHECK(answer(page).type == "text/html; charset=utf-8");
  CHECK(answer(changed(&Asked::target, "/page.js")).type == "text/javascript; charset=utf-8");
  CHECK(answer(changed(&Asked::target, "/body/0")).body == encode_body(simulation, 0));
  CHECK(answer(changed(&Asked::target, "/body/1")).status == 404);
  CHECK(answer(changed(&Asked::target, "/../secret")).status == 404);
  CHECK(answer(changed(&Asked::target, "")).status == 200);
  CHECK(answer(changed(&Asked::host, "evil.example")).status == 403);
  CHECK(answer(changed(&Asked::origin, "http://evil.example")).status == 403);
  CHECK(answer(changed(&Asked::method, "POST")).status == 405);
  CHECK(answer(changed(&Asked::cookies, "")).status == 403);

  Asked first = changed(&Asked::cookies, "");
  first.target = token;
  const Answer admitted = answer(first);
  CHECK(admitted.is_admission);
  CHECK(admitted.set_cookie == cookie_line);
  CHECK(answer(first).status == 403);  // once

  Asked watch = changed(&Asked::target, "/live");
  CHECK_FALSE(may_watch(watch, access));  // a WebSocket comes with its origin
  watch.origin = "http://127.0.0.1:81";
  CHECK(may_watch(watch, access));
  watch.cookies = "";
  CHECK_FALSE(may_watch(watch, access));
}
