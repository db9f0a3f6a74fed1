#include "tests/support/catch.h"
#include "tests/tools/error_code_of.h"
#include "tools/run/options.h"
#include "tools/system/exit_code.h"

using namespace umax;
using umax::test::contains;

namespace {

Options parse(std::vector<const char*> words) {
  words.insert(words.begin(), "umax");
  return parse_command_line(int(words.size()), words.data());
}

std::string message_of(const std::vector<const char*>& words) {
  try {
    parse(words);
  } catch (const Error& error) {
    return exit_code_of(error.fault()) == 2 ? error.what() : "another exit code";
  }
  return "no error";
}

}  // namespace

TEST_CASE("options may stand anywhere") {
  for (const auto& words : std::vector<std::vector<const char*>>{
           {"run", "beam", "-o", "out", "--set", "a=1", "--set", "b=-2", "--threads", "2"},
           {"--threads", "2", "-o", "out", "run", "--set", "a=1", "beam", "--set", "b=-2"},
           {"--set=a=1", "run", "--threads=2", "--set", "b=-2", "--output=out", "beam"}}) {
    const Options options = parse(words);
    CHECK(options.verb == "run");
    CHECK(options.inputs == std::vector<std::string>{"beam"});
    CHECK(options.output == "out");
    CHECK(options.settings == std::vector<std::string>{"a=1", "b=-2"});
    CHECK(options.threads == 2);
  }
}

TEST_CASE("resume and overwrite say what becomes of an existing folder") {
  CHECK(parse({"run", "beam"}).existing_folder() == ExistingFolder::refuse);
  CHECK(parse({"run", "beam", "--resume"}).existing_folder() == ExistingFolder::keep);
  CHECK(parse({"run", "beam", "--overwrite"}).existing_folder() == ExistingFolder::overwrite);
  CHECK(contains(message_of({"run", "beam", "--overwrite", "--resume"}), "exclude"));
}

TEST_CASE("an unknown verb or option names the nearest") {
  CHECK(contains(message_of({"simulat", "beam"}), "umax simulate"));
  CHECK(contains(message_of({"run", "beam", "--thread", "2"}), "--threads"));
  CHECK(contains(message_of({"run", "beam", "--smaples=2"}), "--samples"));
}

TEST_CASE("verbs that are not built say so and are absent from the help") {
  const std::string verb = "export";
  CHECK(contains(message_of({verb.c_str()}), "not in this version"));
  CHECK(!contains(help_text(""), "umax " + verb));
  CHECK(!contains(help_text(""), "\n  " + verb + " "));
}

TEST_CASE("an option of another verb is wrong usage") {
  CHECK(contains(message_of({"compare", "a", "b", "--samples", "4"}), "does not go with umax compare"));
  CHECK(contains(message_of({"run", "beam", "--stretch", "10%"}), "does not go with umax run"));
}

TEST_CASE("values that cannot be are wrong usage") {
  CHECK(message_of({"run", "beam", "--threads", "0"}) != "no error");
  CHECK(message_of({"run", "beam", "--threads", "two"}) != "no error");
  CHECK(message_of({"run", "beam", "--engine", "povray"}) != "no error");
  CHECK(message_of({"run", "beam", "--progress", "pretty"}) != "no error");
  CHECK(message_of({"run", "beam", "--samples", "-4"}) != "no error");
  CHECK(message_of({"run", "beam", "-o"}) != "no error");
  CHECK(message_of({"compare", "a", "b", "--max-flip", "2"}) != "no error");
  CHECK(message_of({}) != "no error");
}

TEST_CASE("every verb has its help, and every option of it stands there") {
  for (const VerbHelp& verb : verbs()) {
    CAPTURE(verb.name);
    CHECK(contains(help_text(""), std::string("\n  ") + verb.name));
    CHECK(contains(help_text(verb.name), std::string("usage: umax ") + verb.name));
  }
  for (const char* option : {"-o,--output DIR", "--set KEY=VALUE", "--frames LIST", "--threads N", "--resume",
                             "--overwrite", "--strict", "--quiet", "--verbose", "--quick", "--progress", "--engine",
                             "--samples N", "--size WxH", "--seed N", "--version", "-h"})
    CHECK(contains(help_text("run"), option));
  CHECK(parse({"-h"}).help);
  CHECK(parse({"run", "-h"}).verb == "run");
}
