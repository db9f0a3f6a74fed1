// The program `umax`: picks the verb, and is the one place where exceptions end.
#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <string>

#include "core/base/error.h"
#include "tools/cli/command_line.h"
#include "tools/cli/help_text.h"
#include "tools/cli/verb.h"
#include "tools/system/exit_code.h"
#include "tools/system/signals.h"
#include "tools/system/version.h"

namespace {

std::string verb;  // once it is known

int run(int argc, char** argv) {
  const umax::Options options = umax::parse_command_line(argc, argv);
  verb = options.verb;
  umax::pin_instruction_set(options.isa, argv);
  if (options.version) {
    fmt::print("{}", umax::version_report());
    return 0;
  }
  if (options.help) {
    fmt::print("{}", options.verb == "help" ? umax::help_text() : umax::help_text(options.verb));
    return 0;
  }
  if (const std::optional<double> seconds = umax::deadline_of(options)) umax::set_deadline(*seconds);
  return umax::find_verb(options.verb).run(options);
}

/// What takes no --resume is not told to go on with it.
std::string told(std::string message) {
  const std::string remedy = "go on with --resume";
  const std::size_t at = message.find(remedy);
  if (at != message.npos && !verb.empty() && !umax::takes_option(umax::find_verb(verb), "--resume"))
    message.replace(at, remedy.size(), "call it again");
  return message;
}

int report(umax::Fault fault, const std::string& message) {
  fmt::print(stderr, "umax: error: {}\n", message);
  return umax::exit_code_of(fault);
}

int guarded_run(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const umax::Error& error) {
    return report(error.fault(), told(error.what()));
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
  const int code = guarded_run(argc, argv);
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  return code == 0 ? report(umax::Fault::io_error, "standard output cannot be written") : code;
}
