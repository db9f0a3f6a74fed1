#include <fmt/format.h>

#include "core/base/error.h"
#include "tools/cli/completion.h"
#include "tools/cli/help_text.h"
#include "tools/cli/man_page.h"
#include "tools/cli/options.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

std::vector<std::string> verb_names() {
  std::vector<std::string> names;
  for (const Verb& verb : verbs()) names.push_back(verb.name);
  return names;
}

std::string text_of(const Options& options) {
  const bool one_thing = int(options.inputs.size()) + options.man + options.completion.has_value() <= 1;
  if (!one_thing)
    throw Error(Fault::usage, {.what = "umax help takes one verb, --man or --completion", .remedy = "see umax help"});
  if (options.man) return man_page();
  if (options.completion) return *options.completion == "zsh" ? zsh_completion() : bash_completion();
  return options.inputs.empty() ? help_text() : help_text(options.inputs.front());
}

int help(const Options& options) {
  fmt::print("{}", text_of(options));
  return 0;
}

}  // namespace

Verb help_verb() {
  return {.name = "help",
          .usage = "[VERB]",
          .summary = "this text, or a verb's options",
          .details =
              "Tells what the program or one of its verbs does. --man prints the manual page umax(1), --completion "
              "what makes bash or zsh complete the words of the program.",
          .examples = {"umax help run", "umax help --man | man -l -", "source <(umax help --completion bash)"},
          .arguments = {.words = verb_names},
          .options = {"--man", "--completion"},
          .run = help};
}

}  // namespace umax
