// The manual page and the completion that are made from the tables of verbs and options, read by those they are for.
#include <algorithm>

#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/tools/program.h"
#include "tools/cli/completion.h"
#include "tools/cli/man_page.h"
#include "tools/cli/option_table.h"
#include "tools/cli/verb.h"

using namespace umax;
using umax::test::contains;

namespace {

/// Whether this machine has the program; tools/packages.test names what tests call.
bool has_program(const std::string& name) {
  if (run_process({"bash", "-c", "command -v " + name}).exit_code == 0) return true;
  WARN(name << " is not here: what it would read is not looked at");
  return false;
}

/// What bash offers for the last of these words, in a folder of some files; "=" is a word of its own, as bash has it.
Words offered(const Words& words) {
  const TemporaryFolder folder;
  make_file(folder / "umax", bash_completion());
  for (const char* file : {"files/cow.obj", "files/falling.toml", "files/pads.csv", "files/a run/states/0001.state"})
    make_file(folder / file, "");
  const std::string complete =
      "cd \"$0/files\" && source ../umax && COMP_WORDS=(umax \"$@\") && COMP_CWORD=$# && _umax && "
      "printf '%s\\n' \"${COMPREPLY[@]}\"";
  const ProcessResult result = run_process(Words{"bash", "-uc", complete, folder.path().string()} + words);
  INFO(result.messages);
  CHECK(result.exit_code == 0);
  CHECK(result.messages.empty());
  Words lines;
  for (std::size_t begin = 0; begin < result.output.size();) {
    const std::size_t end = result.output.find('\n', begin);
    if (end > begin) lines.push_back(result.output.substr(begin, end - begin));
    begin = end + 1;
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

bool offers(const Words& words, const std::string& word) {
  const Words all = offered(words);
  return std::find(all.begin(), all.end(), word) != all.end();
}

}  // namespace

TEST_CASE("bash completes verbs", "[completion]") {
  CHECK(offered({"s"}) == Words{"scenes", "simulate", "strip"});
  CHECK(offered({"--threads", "2", "tu"}) == Words{"tune", "turntable"});
  CHECK(offered({""}).size() == verbs().size());
  CHECK(offered({"help", "rep"}) == Words{"reproduce"});
}

TEST_CASE("bash completes the options that the verb takes", "[completion]") {
  CHECK(offered({"compare", "a.png", "--m"}) == Words{"--max-flip"});
  CHECK(offered({"run", "beam", "--s"}) == Words{"--samples", "--seed", "--set", "--size", "--strict"});
  CHECK(offered({"--size", "64x36", "turntable", "--st"}) == Words{"--stage", "--still"});
  CHECK(offered({"-"}) == Words{"--help", "--version", "-h"});
  for (const Verb& verb : verbs()) {
    Words wanted;
    for (const OptionDefinition& option : option_table())
      if (takes_option(verb, option.name)) wanted.push_back(option.name);
    std::sort(wanted.begin(), wanted.end());
    CAPTURE(verb.name);
    CHECK(offered({verb.name, "--"}) == wanted);
  }
}

TEST_CASE("bash completes values that an option takes", "[completion]") {
  CHECK(offered({"run", "beam", "--engine", ""}) == Words{"embree", "osmesa"});
  CHECK(offered({"run", "beam", "--engine", "=", "o"}) == Words{"osmesa"});
  CHECK(offered({"run", "beam", "--progress", "="}) == Words{"auto", "json", "plain"});
  CHECK(offered({"help", "--completion", "z"}) == Words{"zsh"});
  CHECK(offered({"run", "beam", "-o", "a"}) == Words{"a run"});
  CHECK(offered({"run", "beam", "--samples", ""}).empty());
}

TEST_CASE("bash completes scenes, files and folders where the verb takes them", "[completion]") {
  CHECK(offered({"run", "fi"}) == Words{"figure"});
  CHECK(offered({"run", "f"}) == Words{"falling.toml", "figure"});
  CHECK(offers({"run", "--progress", "=", "json", "b"}, "beam"));
  CHECK(offered({"render", ""}) == Words{"a run"});
  CHECK(offered({"drop", "c"}) == Words{"cow.obj"});
  CHECK(offered({"fit", ""}) == Words{"a run", "pads.csv"});
  CHECK(offers({"inspect", "a"}, "armadillo"));
  CHECK(offers({"presets", "ru"}, "rubber"));
  CHECK(offers({"reproduce", "figure3", "fig"}, "figure6"));
  CHECK(offered({"scenes", ""}).empty());
}

TEST_CASE("zsh reads its completion, which has every verb and its options", "[completion]") {
  const std::string text = zsh_completion();
  CHECK(text.starts_with("#compdef umax\n"));
  for (const Verb& verb : verbs()) CHECK(contains(text, "\n    " + verb.name + ")\n"));
  CHECK(contains(text, "compadd -- armadillo beam "));
  if (!has_program("zsh")) return;
  const TemporaryFolder folder;
  make_file(folder / "_umax", text);
  const ProcessResult read = run_process({"zsh", "-n", (folder / "_umax").string()});
  INFO(read.messages);
  CHECK(read.exit_code == 0);
  CHECK(read.messages.empty());
}

TEST_CASE("zsh completes verbs, options, values and scenes", "[completion]") {
  if (!has_program("zsh")) return;
  const TemporaryFolder folder;
  make_file(folder / "functions/_umax", zsh_completion());
  make_file(folder / "here/falling.toml", "");
  // a shell on a terminal of its own; its last prompt tells that it listens, control-D lists what it would complete
  make_file(folder / "ask.zsh", R"(zmodload zsh/zpty
zpty shell "zsh -f -i"
say() { zpty -w shell "$1" }
say "PROMPT= RPROMPT=; unsetopt zle_bracketed_paste 2>/dev/null; unset zle_bracketed_paste; stty -echo; stty cols 200 rows 2000"
say "fpath=($1/functions \$fpath); autoload -Uz compinit; compinit -u -D; cd $1/here; LISTMAX=10000"
say "bindkey '^D' list-choices; setopt no_beep; PROMPT=REA''DY"
# reads until the words are there, at most 10 s
listen() { text=; repeat 200 { while zpty -rt shell some; do text+=$some; done; [[ $text == *$1* ]] && return; sleep 0.05 } }
listen READY
zpty -w -n shell "$2"$'\x04'
listen "$3"
print -r -- "$text"
zpty -d shell
)");
  const auto list_of = [&](const std::string& line, const std::string& wanted) {
    return run_process({"zsh", "-f", (folder / "ask.zsh").string(), folder.path().string(), line, wanted}).output;
  };
  CHECK(contains(list_of("umax tu", "turntable"), "turntable"));
  CHECK(contains(list_of("umax compare --max", "largest mean"), "largest mean FLIP that passes"));
  CHECK(contains(list_of("umax run beam --engine ", "osmesa"), "osmesa"));
  const std::string scenes = list_of("umax run f", "falling.toml");
  CHECK(contains(scenes, "figure"));
  CHECK(contains(scenes, "falling.toml"));
}

TEST_CASE("groff reads the manual page without a warning", "[completion]") {
  if (!has_program("groff")) return;
  const TemporaryFolder folder;
  make_file(folder / "umax.1", man_page());
  const ProcessResult page =
      run_process({"groff", "-man", "-Tascii", "-P-cbou", "-ww", "-rLL=100n", (folder / "umax.1").string()});
  INFO(page.messages);
  CHECK(page.exit_code == 0);
  CHECK(page.messages.empty());
  for (const Verb& verb : verbs()) CHECK(contains(page.output, "umax " + verb.name));
  for (const OptionDefinition& option : option_table()) CHECK(contains(page.output, option.name));
  CHECK(contains(page.output, "umax run beam --set body.beam.limit.energy=0.1J --set clip.frames=60"));
}

TEST_CASE("the manual page has its sections, every verb, option and exit code", "[completion]") {
  const std::string page = man_page();
  CHECK(page.starts_with(".TH UMAX 1 "));
  for (const char* section : {"NAME", "SYNOPSIS", "DESCRIPTION", "VERBS", "OPTIONS", "EXIT STATUS", "ENVIRONMENT"})
    CHECK(contains(page, std::string("\n.SH ") + section + "\n"));
  for (const Verb& verb : verbs()) CHECK(contains(page, "\n.SS umax " + verb.name));
  CHECK(contains(page, "\n\\fB75\\fR\n"));
}

TEST_CASE("the program prints manual page and completion", "[completion]") {
  CHECK(umax_program({"help", "--man"}).output == man_page());
  CHECK(umax_program({"help", "--completion", "bash"}).output == bash_completion());
  CHECK(umax_program({"help", "--completion=zsh"}).output == zsh_completion());
  for (const Words& wrong : {Words{"help", "--completion", "fish"}, Words{"help", "run", "--man"},
                             Words{"run", "beam", "--man"}, Words{"help", "run", "simulate"}})
    CHECK(exit_code_of(wrong) == 2);
}
