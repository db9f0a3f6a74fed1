// The program `umax`: picks the verb, and is the one place where exceptions end.
#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <new>

#include "core/base/error.h"
#include "tools/cli/verbs.h"
#include "tools/system/exit_code.h"
#include "tools/system/machine_memory.h"
#include "tools/system/version.h"

namespace {

using umax::Options;

int run_verb(const Options& options) {
  static const std::map<std::string, int (*)(const Options&)> functions{
      {"run", umax::verb_run},         {"simulate", umax::verb_simulate},
      {"render", umax::verb_render},   {"turntable", umax::verb_turntable},
      {"drop", umax::verb_drop},       {"strip", umax::verb_strip},
      {"inspect", umax::verb_inspect}, {"scenes", umax::verb_scenes},
      {"presets", umax::verb_presets}, {"reproduce", umax::verb_reproduce},
      {"tune", umax::verb_tune},       {"fit", umax::verb_fit},
      {"compare", umax::verb_compare}, {"help", umax::verb_help}};
  return functions.at(options.verb)(options);
}

int run(int argc, char** argv) {
  const Options options = umax::parse_command_line(argc, argv);
  if (options.version) {
    fmt::print("umax {}\n", umax::version_text());
    return 0;
  }
  if (options.help) {
    fmt::print("{}", umax::help_text(options.verb == "help" ? "" : options.verb));
    return 0;
  }
  return run_verb(options);
}

int report(umax::Fault fault, const std::string& message) {
  fmt::print(stderr, "umax: error: {}\n", message);
  return umax::exit_code_of(fault);
}

int guarded_run(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const umax::Error& error) {
    return report(error.fault(), error.what());
  } catch (const std::bad_alloc&) {
    return report(umax::Fault::internal, "memory ran out; fewer cells, smaller pictures or another machine help");
  } catch (const std::exception& error) {
    return report(umax::Fault::internal,
                  fmt::format("internal: {}; please report it with the command and the scene", error.what()));
  }
}

}  // namespace

int main(int argc, char** argv) {
  // a file-size limit is a write that fails, and is reported as one
  std::signal(SIGXFSZ, SIG_IGN);
  umax::keep_freed_memory();
  const int code = guarded_run(argc, argv);
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  return code == 0 ? report(umax::Fault::io_error, "standard output cannot be written") : code;
}
