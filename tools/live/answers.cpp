#include "tools/live/answers.h"

#include <fmt/format.h>

#include <optional>

#include "tools/live/wire.h"

namespace umax {
namespace {

const char* type_of(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  return "application/octet-stream";
}

std::optional<std::string> file_called(const std::string& name, const std::map<std::string, std::string>& files,
                                       const Simulation& simulation) {
  if (const auto found = files.find(name); found != files.end()) return found->second;
  for (std::size_t i = 0; i < simulation.bodies.size(); ++i)
    if (name == fmt::format("body/{}", i)) return encode_body(simulation, i);
  for (std::size_t i = 0; i < simulation.obstacles.size(); ++i)
    if (name == fmt::format("obstacle/{}", i)) return encode_obstacle(simulation, i);
  return std::nullopt;
}

Answer refusal(int status, const std::string& why) {
  return {.status = status, .body = why + "\n"};
}

/// Not a redirection: a browser sends the cookie along only where the page's own site asks.
Answer admission(const Access& access) {
  return {.body =
              "<!DOCTYPE html><link rel=\"icon\" href=\"data:,\"><meta http-equiv=\"refresh\" content=\"0;url=/\">"
              "<title>umax live</title>",
          .type = "text/html; charset=utf-8",
          .set_cookie = cookie_of(access),
          .is_admission = true};
}

}  // namespace

Answer answer_to(const Asked& asked, const std::map<std::string, std::string>& files, const Simulation& simulation,
                 Access& access) {
  if (!is_local_host(asked.host)) return refusal(403, "This server is for this machine alone.");
  if (!asked.origin.empty() && !is_own_origin(asked.origin, asked.host))
    return refusal(403, "Other sites may not ask.");
  if (asked.method != "GET") return refusal(405, "GET is what there is.");
  if (take_token(access, asked.target)) return admission(access);
  if (!has_secret(access, asked.cookies))
    return refusal(403,
                   "The address has been used, or is not the one of this session: take the last one that umax live has "
                   "said in the terminal.");
  const std::string name(asked.target.size() > 1 ? asked.target.substr(1) : "page.html");
  const std::optional<std::string> body = file_called(name, files, simulation);
  if (!body) return refusal(404, "There is no such file.");
  return {.body = *body, .type = type_of(name)};
}

bool may_watch(const Asked& asked, const Access& access) {
  return asked.target == "/live" && is_own_origin(asked.origin, asked.host) && has_secret(access, asked.cookies);
}

}  // namespace umax
