#include <fmt/format.h>

#include "tools/cli/completion.h"
#include "tools/cli/option_table.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

/// Text for single quotes in a specification of _arguments: what means something there is escaped.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '\'')
      result += "'\\'";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      result += '\\';
    result += c;
  }
  return result;
}

std::string value_action(const OptionDefinition& option) {
  const std::vector<std::string>& words = option.choices.empty() ? option.examples : option.choices;
  if (!words.empty()) return fmt::format("({})", fmt::join(words, " "));
  return option.is_path ? "_files" : " ";
}

/// "'(-o --output)'{-o,--output}'[description]:DIR:_files'"
std::string option_specification(const OptionDefinition& option) {
  const bool repeats = std::holds_alternative<std::vector<std::string> Options::*>(option.target);
  const std::string name = option.value.empty() ? option.name : option.name + "=";
  std::string head = "'" + std::string(repeats ? "*" : "") + name;
  if (!option.short_name.empty()) head = fmt::format("'({0} {1})'{{{0},{2}}}'", option.short_name, option.name, name);
  std::string text = head + "[" + escaped(option.description) + "]";
  if (!option.value.empty()) text += ":" + escaped(option.value) + ":" + value_action(option);
  return text + "'";
}

/// "'*:SCENE:{ compadd beam figure; _files -g "*.toml" }'"
std::string argument_specification(const Verb& verb) {
  const Arguments& arguments = verb.arguments;
  std::string actions;
  if (arguments.words != nullptr) actions += fmt::format(" compadd -- {};", fmt::join(arguments.words(), " "));
  for (const std::string& ending : arguments.endings)
    actions += ending == "*" ? " _files;" : " _files -g \"*." + ending + "\";";
  if (arguments.folders) actions += " _files -/;";
  return actions.empty() ? "" : " \\\n        '*:" + escaped(verb.usage) + ":{" + actions + " }'";
}

}  // namespace

std::string zsh_completion() {
  std::string names, cases;
  for (const Verb& verb : verbs()) {
    names += "    '" + escaped(verb.name) + ":" + escaped(verb.summary) + "'\n";
    cases += "    " + verb.name + ")\n      _arguments -s -S";
    for (const OptionDefinition& option : option_table())
      if (takes_option(verb, option.name)) cases += " \\\n        " + option_specification(option);
    cases += argument_specification(verb) + " ;;\n";
  }
  return "#compdef umax\n# zsh completion for umax; written by umax help --completion zsh\n\n_umax() {\n"
         "  local context state state_descr line\n  typeset -A opt_args\n  local -a verbs\n  verbs=(\n" +
         names +
         "  )\n  _arguments -C '(- *)'{-h,--help}'[what the program does]' '(- *)--version[its version]' "
         "'1:verb:->verb' '*::argument:->argument'\n"
         "  if [[ $state == verb ]]; then\n    _describe -t verbs verb verbs\n    return\n  fi\n"
         "  case $words[1] in\n" +
         cases + "  esac\n}\n\n_umax \"$@\"\n";
}

}  // namespace umax
