#include <set>
#include <sstream>

#include "tests/support/catch.h"
#include "tests/tools/error_code_of.h"
#include "tools/cli/command_line.h"
#include "tools/cli/help_text.h"
#include "tools/cli/option_table.h"
#include "tools/cli/verb.h"
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
  CHECK(existing_folder(parse({"run", "beam"})) == ExistingFolder::refuse);
  CHECK(existing_folder(parse({"run", "beam", "--resume"})) == ExistingFolder::keep);
  CHECK(existing_folder(parse({"run", "beam", "--overwrite"})) == ExistingFolder::overwrite);
  CHECK(contains(message_of({"run", "beam", "--overwrite", "--resume"}), "exclude"));
}

TEST_CASE("an unknown verb or option names the nearest") {
  CHECK(contains(message_of({"simulat", "beam"}), "umax simulate"));
  CHECK(contains(message_of({"run", "beam", "--thread", "2"}), "--threads"));
  CHECK(contains(message_of({"run", "beam", "--smaples=2"}), "--samples"));
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
  for (const Verb& verb : verbs()) {
    CAPTURE(verb.name);
    CHECK(contains(help_text(), std::string("\n  ") + verb.name + " "));
    CHECK(contains(help_text(), verb.summary));
    const std::string text = help_text(verb.name);
    CHECK(contains(text, "usage: umax " + verb.name));
    for (const std::string& example : verb.examples) CHECK(contains(text, "\n  " + example + "\n"));
    for (const OptionDefinition& option : option_table())
      CHECK(contains(text, "\n  " + usage(option)) == takes_option(verb, option.name));
  }
  for (const char* option : {"-o,--output DIR", "--set KEY=VALUE", "--frames LIST", "--threads N", "--resume",
                             "--overwrite", "--strict", "--quiet", "--verbose", "--quick", "--progress", "--engine",
                             "--samples N", "--size WxH", "--seed N", "--version", "-h"})
    CHECK(contains(help_text("run"), option));
  CHECK(parse({"-h"}).help);
  CHECK(parse({"run", "-h"}).verb == "run");
}

TEST_CASE("help breaks its lines at 100 columns, but for commands to copy") {
  for (const Verb& verb : verbs()) {
    std::istringstream lines(help_text(verb.name));
    for (std::string line; std::getline(lines, line);) {
      CAPTURE(line);
      CHECK((line.size() <= 100 || line.starts_with("  umax ")));
      CHECK(!line.ends_with(' '));
    }
  }
}

TEST_CASE("the verbs take options of the table, and every option is some verb's") {
  std::set<std::string> defined, taken{"--help", "--version"};
  for (const OptionDefinition& option : option_table()) {
    CAPTURE(option.name);
    CHECK(defined.insert(option.name).second);
    CHECK((option.value.empty() == std::holds_alternative<bool Options::*>(option.target)));
  }
  for (const Verb& verb : verbs())
    for (const std::string& name : verb.options) {
      CAPTURE(verb.name, name);
      CHECK(defined.count(name) == 1);
      taken.insert(name);
    }
  CHECK(taken == defined);
}

TEST_CASE("the command line becomes what runs take") {
  const Options options =
      parse({"simulate", "beam", "--frames", "1-4", "--memory", "2G", "--strict", "--progress", "json"});
  const RunOptions run = run_options(options, 3);
  CHECK(run.verb == "simulate");
  CHECK(run.frames == "1-4");
  CHECK(run.threads == 3);
  CHECK(run.memory == 2LL << 30);
  CHECK(run.strict);
  CHECK(!run.verbose);
  CHECK(progress_mode(options) == ProgressMode::json);
  CHECK(!run_options(parse({"simulate", "beam"}), 1).memory);
  CHECK(progress_mode(parse({"simulate", "beam"})) == ProgressMode::automatic);
}

TEST_CASE("options of pictures become settings of the scene that win over --set, and those over --quick") {
  const std::vector<Override> settings = scene_overrides(parse(
      {"run", "beam", "--quick", "--set", "render.samples=7", "--samples", "9", "--size", "64x36", "--seed", "5"}));
  std::vector<std::string> lines;
  for (const Override& setting : settings) lines.push_back(setting.key + "=" + setting.value);
  CHECK(lines == std::vector<std::string>{"render.size=[320, 180]", "render.samples=4", "render.preview=false",
                                          "render.samples=7", "render.samples=9", "render.size=64x36",
                                          "render.seed=5"});
}
