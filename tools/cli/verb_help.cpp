#include <fmt/format.h>

#include "core/base/error.h"
#include "scenes/scene_key_table.h"
#include "tools/cli/completion.h"
#include "tools/cli/help_text.h"
#include "tools/cli/man_page.h"
#include "tools/cli/options.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

std::vector<std::string> topics() {
  std::vector<std::string> names{"scene"};
  for (const Verb& verb : verbs()) names.push_back(verb.name);
  return names;
}

std::string text_of(const Options& options) {
  const bool one_thing = int(options.inputs.size()) + options.man + options.completion.has_value() <= 1;
  if (!one_thing)
    throw Error(Fault::usage, {.what = "umax help takes one verb, --man or --completion", .remedy = "see umax help"});
  if (options.man) return man_page();
  if (options.completion) return *options.completion == "zsh" ? zsh_completion() : bash_completion();
  if (options.inputs.empty()) return help_text();
  return options.inputs.front() == "scene" ? scene_key_help() : help_text(options.inputs.front());
}

int help(const Options& options) {
  fmt::print("{}", text_of(options));
  return 0;
}

}  // namespace

Verb help_verb() {
  return {.name = "help",
          .usage = "[VERB|scene]",
          .summary = "this text, a verb's options, or all keys of a scene",
          .details =
              "Tells what the program or one of its verbs does, or every key of a scene file. --man prints the manual "
              "page umax(1), --completion "
              "what makes bash or zsh complete the words of the program.",
          .examples = {"umax help run", "umax help scene", "umax help --man | man -l -",
                       "source <(umax help --completion bash)"},
          .arguments = {.words = topics},
          .options = {"--man", "--completion"},
          .run = help};
}

}  // namespace umax
