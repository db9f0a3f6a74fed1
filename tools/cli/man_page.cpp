#include "tools/cli/man_page.h"

#include "tools/cli/help_text.h"
#include "tools/cli/option_table.h"
#include "tools/cli/verb.h"
#include "tools/system/version.h"

namespace umax {
namespace {

/// Text that roff prints as it stands: "-" stays a minus, which can be copied to a shell.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else
      result += c;
  }
  // a line that begins with one of these would be a request
  if (result.starts_with('.') || result.starts_with('\'')) result.insert(0, "\\&");
  return result;
}

std::string bold(std::string_view text) {
  return "\\fB" + escaped(text) + "\\fR";
}

std::string italic(std::string_view text) {
  return "\\fI" + escaped(text) + "\\fR";
}

std::string term(const std::string& what, const std::string& meaning) {
  return ".TP\n" + what + "\n" + escaped(meaning) + "\n";
}

std::string usage_in_fonts(const OptionDefinition& option) {
  return (option.short_name.empty() ? "" : bold(option.short_name) + ", ") + bold(option.name) +
         (option.value.empty() ? "" : " " + italic(option.value));
}

std::string verb_section(const Verb& verb) {
  std::string text = ".SS umax " + escaped(verb.name) + (verb.usage.empty() ? "" : " " + escaped(verb.usage)) + "\n";
  for (const std::string& paragraph : paragraphs_of(verb.details)) text += ".PP\n" + escaped(paragraph) + "\n";
  if (!verb.examples.empty()) {
    text += ".PP\n.EX\n";
    for (const std::string& example : verb.examples) text += "  " + escaped(example) + "\n";
    text += ".EE\n";
  }
  std::string names;
  for (const OptionDefinition& option : option_table())
    if (takes_option(verb, option.name)) names += (names.empty() ? "" : ", ") + bold(option.name);
  return text + ".PP\nOptions: " + names + ".\n";
}

}  // namespace

std::string man_page() {
  std::string text = ".TH UMAX 1 \"\" \"umax " + escaped(version_text()) + "\" \"User Commands\"\n.nh\n.ad l\n";
  text += ".SH NAME\numax \\- soft bodies that stop deforming exactly where you say\n";
  text += ".SH SYNOPSIS\n" + bold("umax") + " " + italic("VERB") + " [" + italic("arguments") + "] [" +
          italic("options") + "]\n";
  text += ".SH DESCRIPTION\n" +
          escaped(
              "Simulates soft bodies with hard limits on their deformation, draws them and encodes clips. SCENE is "
              "a .toml file or the name of a built-in scene (umax scenes). DIR is the folder of a run. Options and "
              "arguments may stand in any order.") +
          "\n";
  text += ".SH VERBS\n";
  for (const Verb& verb : verbs()) text += term(bold("umax " + verb.name) + " " + italic(verb.usage), verb.summary);
  text += ".SH OPTIONS\nEach verb takes those that stand with it below.\n";
  for (const OptionDefinition& option : option_table()) text += term(usage_in_fonts(option), option.description);
  text += ".SH THE VERBS ONE BY ONE\n";
  for (const Verb& verb : verbs()) text += verb_section(verb);
  text += ".SH EXIT STATUS\n";
  for (const ExitCodeMeaning& code : exit_codes()) text += term(bold(code.code), code.meaning);
  text += ".SH ENVIRONMENT\n" + term(bold("UMAX_JAVASCRIPT"),
                                     "the folder that umax tune takes chart.js from; default: where libjs-chart.js "
                                     "puts it");
  return text + ".SH SEE ALSO\n" + bold("ffmpeg") + "(1)\n";
}

}  // namespace umax
