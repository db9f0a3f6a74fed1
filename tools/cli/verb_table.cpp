#include <algorithm>

#include "core/base/error.h"
#include "core/base/nearest_word.h"
#include "tools/cli/verb.h"

// Every verb, in the order of help: verb_NAME.cpp defines `Verb NAME_verb()`.
#define UMAX_VERBS(verb)                                                                                               \
  verb(run) verb(simulate) verb(render) verb(encode) verb(turntable) verb(strip) verb(drop) verb(export) verb(inspect) \
      verb(scenes) verb(presets) verb(reproduce) verb(tune) verb(aim) verb(live) verb(farm) verb(fit) verb(compare)    \
          verb(doctor) verb(help)

namespace umax {

#define UMAX_DECLARE(name) Verb name##_verb();
UMAX_VERBS(UMAX_DECLARE)
#undef UMAX_DECLARE

const std::vector<Verb>& verbs() {
#define UMAX_CALL(name) name##_verb(),
  static const std::vector<Verb> all{UMAX_VERBS(UMAX_CALL)};
#undef UMAX_CALL
  return all;
}

const Verb& find_verb(const std::string& name) {
  std::vector<std::string> known;
  for (const Verb& verb : verbs()) {
    if (verb.name == name) return verb;
    known.push_back(verb.name);
  }
  throw Error(Fault::usage, {.what = "unknown verb \"" + name + "\"",
                             .remedy = "did you mean umax " + nearest_word(name, known) + "? See umax help"});
}

bool takes_option(const Verb& verb, const std::string& long_name) {
  if (long_name == "--help" || long_name == "--version") return true;
  return std::find(verb.options.begin(), verb.options.end(), long_name) != verb.options.end();
}

}  // namespace umax
