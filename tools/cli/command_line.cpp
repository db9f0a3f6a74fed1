#include "tools/cli/command_line.h"

#include <CLI/CLI.hpp>

#include "core/base/error.h"
#include "core/base/nearest_word.h"
#include "tools/cli/option_table.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

[[noreturn]] void usage_error(const std::string& what, const std::string& remedy) {
  throw Error(Fault::usage, {.what = what, .remedy = remedy});
}

/// Puts the definition into CLI11's grammar; its value will go to `options`.
CLI::Option* add_option(const OptionDefinition& definition, Options& options, CLI::App& grammar) {
  const std::string names = (definition.short_name.empty() ? "" : definition.short_name + ",") + definition.name;
  const auto add = [&](auto target) {
    using Value = std::remove_reference_t<decltype(options.*target)>;
    if constexpr (std::is_same_v<Value, bool>) {
      return grammar.add_flag(names, options.*target);
    } else {
      CLI::Option* option = grammar.add_option(names, options.*target);
      if constexpr (std::is_same_v<Value, std::vector<std::string>>) option->allow_extra_args(false);
      return option;
    }
  };
  CLI::Option* option = std::visit(add, definition.target);
  if (!definition.choices.empty()) option->check(CLI::IsMember(definition.choices));
  if (definition.range) option->check(CLI::Range(definition.range->least, definition.range->largest));
  if (definition.check != nullptr) option->check(definition.check, definition.value);
  return option;
}

[[noreturn]] void refuse_unknown(const std::string& extra) {
  std::vector<std::string> known;
  for (const OptionDefinition& definition : option_table()) known.push_back(definition.name);
  const std::string word = extra.substr(0, extra.find('='));
  usage_error("unknown option " + word, "did you mean " + nearest_word(word, known) + "? See umax help");
}

/// Reads the line; returns the long names of the options that stand on it.
std::vector<std::string> read_words(int argc, const char* const* argv, Options& options) {
  CLI::App grammar("umax");
  grammar.set_help_flag("");
  grammar.allow_extras();
  std::vector<std::string> words, given;
  grammar.add_option("words", words);
  std::vector<const CLI::Option*> known;
  for (const OptionDefinition& definition : option_table()) known.push_back(add_option(definition, options, grammar));
  try {
    grammar.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    usage_error(error.what(), "see umax help");
  }
  for (const std::string& extra : grammar.remaining()) refuse_unknown(extra);
  if (!words.empty()) options.verb = words.front();
  if (words.size() > 1) options.inputs.assign(words.begin() + 1, words.end());
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i]->count() > 0) given.push_back(option_table()[i].name);
  return given;
}

}  // namespace

Options parse_command_line(int argc, const char* const* argv) {
  Options options;
  const std::vector<std::string> given = read_words(argc, argv, options);
  if (options.verb.empty()) {
    if (!options.help && !options.version) usage_error("no verb is given", "try umax help, or umax run figure");
    options.verb = "help";
    return options;
  }
  const Verb& verb = find_verb(options.verb);
  for (const std::string& name : given)
    if (!takes_option(verb, name))
      usage_error(name + " does not go with umax " + verb.name, "see umax help " + verb.name);
  if (options.resume && options.overwrite)
    usage_error("--resume and --overwrite exclude each other", "give one of them");
  return options;
}

}  // namespace umax
