#include "tests/support/catch.h"
#include "tests/tools/error_code_of.h"
#include "tools/run/frame_list.h"

using namespace umax;

TEST_CASE("a frame list names numbers, ranges and strides") {
  CHECK(parse_frame_list("5") == std::vector<int>{5});
  CHECK(parse_frame_list("1-4") == std::vector<int>{1, 2, 3, 4});
  CHECK(parse_frame_list("60-66x2") == std::vector<int>{60, 62, 64, 66});
  CHECK(parse_frame_list("60-65x2") == std::vector<int>{60, 62, 64});
  CHECK(parse_frame_list("1-3,5,8-9") == std::vector<int>{1, 2, 3, 5, 8, 9});
}

TEST_CASE("a frame list comes out in order and without repeats") {
  CHECK(parse_frame_list("9,1-3,2") == std::vector<int>{1, 2, 3, 9});
}

TEST_CASE("frames past the clip are left out, unless none remains") {
  CHECK(parse_frame_list("101-130", 120).back() == 120);
  CHECK(parse_frame_list("1,200", 120) == std::vector<int>{1});
  CHECK(error_code_of([] { parse_frame_list("121-130", 120); }) == 2);
}

TEST_CASE("what is no frame list is wrong usage") {
  const std::string text = GENERATE("", "0", "-3", "1-", "a", "1-2-3", "4-2", "1,,2", "1,", "1-4x0", "1-4x", "1 - 4",
                                    "1.5", "+1", "99999999999", "1-4y2");
  CAPTURE(text);
  CHECK(error_code_of([&] { parse_frame_list(text); }) == 2);
}

TEST_CASE("frame names have four digits or more") {
  CHECK(frame_name(1) == "0001");
  CHECK(frame_name(9999) == "9999");
  CHECK(frame_name(12345) == "12345");
}

TEST_CASE("a list of frames and its text are each other's inverse") {
  for (const char* text : {"1", "1-12", "1-3,5,7-8", "12", ""})
    CHECK(frame_list_text(*text ? parse_frame_list(text) : std::vector<int>()) == text);
}
