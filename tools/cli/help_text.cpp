#include "tools/cli/help_text.h"

#include <algorithm>

#include "tools/cli/option_table.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

constexpr std::size_t page_width = 100, option_indent = 26, verb_indent = 32;

/// The words in lines of at most page_width columns; all but the first line are indented. `line` is what stands there
/// already.
std::string filled(std::string line, std::string_view words, std::size_t indent) {
  std::string text;
  bool at_start = true;
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = std::min(words.find(' ', begin), words.size());
    const std::string_view word = words.substr(begin, end - begin);
    if (!at_start && line.size() + 1 + word.size() > page_width) {
      text += line + "\n";
      line.assign(indent, ' ');
      at_start = true;
    }
    if (!at_start) line += ' ';
    line += word;
    at_start = false;
    begin = end + 1;
  }
  return text + line + "\n";
}

/// A term with what it means beside it, below it if it is long.
std::string entry(const std::string& term, const std::string& meaning, std::size_t indent) {
  std::string line = "  " + term;
  if (line.size() < indent) {
    line.resize(indent, ' ');
    return filled(line, meaning, indent);
  }
  return line + "\n" + filled(std::string(indent, ' '), meaning, indent);
}

std::string usage_line(const Verb& verb) {
  return "umax " + verb.name + (verb.usage.empty() ? "" : " " + verb.usage) + " [options]";
}

}  // namespace

const std::vector<ExitCodeMeaning>& exit_codes() {
  static const std::vector<ExitCodeMeaning> all{
      {"0", "success"},
      {"1", "compare: the pictures differ"},
      {"2", "wrong usage"},
      {"3", "aim: the want was not reached; the nearest is shown"},
      {"65", "bad scene, mesh, state or data"},
      {"66", "an input is not found"},
      {"69", "a helper program is missing"},
      {"70", "internal error"},
      {"73", "the output cannot be created"},
      {"74", "a read or write failed later"},
      {"75", "try again: the folder is in use, the --deadline is over, or with --strict a step did not converge"},
      {"128+n", "ended by signal n; what was finished is kept"}};
  return all;
}

std::vector<std::string> paragraphs_of(std::string_view text) {
  std::vector<std::string> paragraphs;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find("\n\n", begin), text.size());
    paragraphs.emplace_back(text.substr(begin, end - begin));
    begin = end + 2;
  }
  return paragraphs;
}

std::string help_text() {
  std::string text = "umax: soft bodies that stop deforming exactly where you say\n\nusage: umax VERB [options]\n\n";
  for (const Verb& verb : verbs()) text += entry(verb.name + " " + verb.usage, verb.summary, verb_indent);
  text += "\n" + filled("",
                        "SCENE is a .toml file or the name of a built-in scene (umax scenes). DIR is the folder of a "
                        "run. umax help VERB tells a verb's options.",
                        0);
  std::string codes = "Exit codes:";
  for (const ExitCodeMeaning& code : exit_codes())
    codes += std::string(codes.ends_with(':') ? " " : "; ") + code.code + " " + code.meaning;
  return text + filled("", codes + ".", 0);
}

std::string help_text(const std::string& name) {
  const Verb& verb = find_verb(name);
  std::string text = "usage: " + usage_line(verb) + "\n\n";
  for (const std::string& paragraph : paragraphs_of(verb.details)) text += filled("", paragraph, 0) + "\n";
  for (const std::string& example : verb.examples) text += "  " + example + "\n";
  if (!verb.examples.empty()) text += "\n";
  text += "options, in any order:\n";
  for (const OptionDefinition& option : option_table())
    if (takes_option(verb, option.name)) text += entry(usage(option), option.description, option_indent);
  return text;
}

}  // namespace umax
