#include <fmt/format.h>

#include "tools/cli/completion.h"
#include "tools/cli/option_table.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

constexpr const char* head = R"(# bash completion for umax; written by umax help --completion bash

# words of a list, files with an ending ("*": any), folders: each appends to COMPREPLY what begins with the word
_umax_words() { mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -W "$1" -- "$word"); }
_umax_files() {
  compopt -o filenames 2>/dev/null
  if [[ $1 == '*' ]]; then mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -- "$word"); return; fi
  mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -X "!*.$1" -- "$word")
}
_umax_folders() {
  compopt -o filenames 2>/dev/null
  mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -d -- "$word")
}

_umax() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} verb= options= i
  COMPREPLY=()
  # bash cuts --option=value into three words
  if [[ $word == = ]]; then
    word=
  elif [[ $before == = && $COMP_CWORD -gt 2 ]]; then
    before=${COMP_WORDS[COMP_CWORD-2]}
  fi

  # the verb is the first word that is neither an option nor an option's value
  for ((i = 1; i < COMP_CWORD; i++)); do
    case ${COMP_WORDS[i]} in
)";

std::string joined(const std::vector<std::string>& words, const char* separator = " ") {
  return fmt::format("{}", fmt::join(words, separator));
}

std::string pattern(const OptionDefinition& option) {
  return option.short_name.empty() ? option.name : option.short_name + "|" + option.name;
}

std::string value_case(const OptionDefinition& option) {
  std::string action;
  if (!option.choices.empty()) action = "_umax_words '" + joined(option.choices) + "'; ";
  if (!option.examples.empty()) action = "_umax_words '" + joined(option.examples) + "'; ";
  if (option.is_path) action = "_umax_files '*'; ";
  return "    " + pattern(option) + ") " + action + "return ;;\n";
}

std::string options_of(const Verb& verb) {
  std::vector<std::string> names;
  for (const OptionDefinition& option : option_table()) {
    if (!takes_option(verb, option.name)) continue;
    if (!option.short_name.empty()) names.push_back(option.short_name);
    names.push_back(option.name);
  }
  return joined(names);
}

/// What to do where the verb's argument stands.
std::string argument_case(const Verb& verb) {
  const Arguments& arguments = verb.arguments;
  std::string actions;
  if (arguments.words != nullptr) actions += " _umax_words '" + joined(arguments.words()) + "';";
  for (const std::string& ending : arguments.endings) actions += " _umax_files '" + ending + "';";
  if (arguments.folders) actions += " _umax_folders;";
  return actions.empty() ? "" : "    " + verb.name + ")" + actions + " ;;\n";
}

}  // namespace

std::string bash_completion() {
  std::vector<std::string> with_value, verb_names;
  std::string values, options, arguments;
  for (const OptionDefinition& option : option_table()) {
    if (option.value.empty()) continue;
    with_value.push_back(pattern(option));
    values += value_case(option);
  }
  for (const Verb& verb : verbs()) {
    verb_names.push_back(verb.name);
    options += "    " + verb.name + ") options='" + options_of(verb) + "' ;;\n";
    arguments += argument_case(verb);
  }
  return head + ("      " + joined(with_value, "|") + ")\n        ((i++))\n") +
         R"(        [[ ${COMP_WORDS[i]} == = ]] && ((i++)) ;;
      -*) ;;
      *) verb=${COMP_WORDS[i]}; break ;;
    esac
  done

  case $before in
)" + values +
         R"(  esac
  case $verb in
)" + options +
         R"(    '') options='-h --help --version' ;;
  esac
  if [[ $word == -* ]]; then
    _umax_words "$options"
    return
  fi
  case $verb in
    '') _umax_words ')" +
         joined(verb_names) + "' ;;\n" + arguments + "  esac\n}\ncomplete -F _umax umax\n";
}

}  // namespace umax
