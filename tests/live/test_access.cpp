#include "tools/live/access.h"

#include <set>

#include "tests/support/catch.h"
#include "tests/support/failure.h"

using namespace umax;
using umax::test::contains;

TEST_CASE("only names of this machine are hosts") {
  for (const char* host : {"127.0.0.1", "127.0.0.1:8123", "localhost", "localhost:65535"}) CHECK(is_local_host(host));
  for (const char* host : {"", "example.com", "example.com:8123", "127.0.0.1.example.com", "localhost.example.com",
                           "127.0.0.1:", "127.0.0.1:80a", "evil@127.0.0.1", "127.0.0.2", "0.0.0.0", "[::1]:80",
                           "127.0.0.1:8123:8123", "localhost:123456"})
    CHECK_FALSE(is_local_host(host));
}

TEST_CASE("an origin is ours where it is this host's own page") {
  CHECK(is_own_origin("http://127.0.0.1:8123", "127.0.0.1:8123"));
  CHECK(is_own_origin("http://localhost:8123", "localhost:8123"));
  for (const char* origin : {"", "null", "http://evil.example", "https://127.0.0.1:8123", "http://127.0.0.1:8124",
                             "http://localhost:8123", "http://127.0.0.1:8123.evil.example", "http://127.0.0.1:8123/"})
    CHECK_FALSE(is_own_origin(origin, "127.0.0.1:8123"));
  CHECK_FALSE(is_own_origin("http://evil.example", "evil.example"));
}

TEST_CASE("a token opens once, and the next one is another") {
  Access access = new_access();
  const std::string first = access.token;
  CHECK_FALSE(take_token(access, "/"));
  CHECK_FALSE(take_token(access, "/?token="));
  CHECK_FALSE(take_token(access, "/?token=" + std::string(32, '0')));
  CHECK_FALSE(take_token(access, "/x?token=" + first));
  CHECK_FALSE(take_token(access, "/?token=" + first + "0"));
  CHECK_FALSE(take_token(access, "/?token=" + first.substr(1)));
  CHECK(access.token == first);
  CHECK(take_token(access, "/?token=" + first));
  CHECK_FALSE(take_token(access, "/?token=" + first));
  CHECK(take_token(access, "/?token=" + access.token));
}

TEST_CASE("the cookie's secret is found among cookies, and nothing like it") {
  const Access access = new_access();
  const std::string pair = access.cookie + "=" + access.secret;
  CHECK(has_secret(access, pair));
  CHECK(has_secret(access, "a=b; " + pair + "; c=d"));
  CHECK(has_secret(access, "a=b;" + pair));
  for (const std::string& cookies :
       {std::string(), access.secret, access.cookie, access.cookie + "=", pair + "0", pair.substr(0, pair.size() - 1),
        "x" + pair, access.cookie + "x=" + access.secret, access.cookie + "=" + access.token})
    CHECK_FALSE(has_secret(access, cookies));
  CHECK(contains(cookie_of(access), "HttpOnly"));
  CHECK(contains(cookie_of(access), "SameSite=Strict"));
}

TEST_CASE("random words are long and all different") {
  std::set<std::string> words;
  for (int i = 0; i < 1000; ++i) words.insert(random_word());
  CHECK(words.size() == 1000);
  for (const std::string& word : words) CHECK(word.size() == 32);
}
