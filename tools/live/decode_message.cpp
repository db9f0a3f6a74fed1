// What a browser may say, read: apart from what it is told, since it needs no session.
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/live/messages.h"

namespace umax {
namespace {

using nlohmann::json;

constexpr std::array<std::pair<const char*, Wish>, 19> words{{{"play", Wish::play},
                                                              {"pause", Wish::pause},
                                                              {"step", Wish::step},
                                                              {"restart", Wish::restart},
                                                              {"slower", Wish::slower},
                                                              {"set", Wish::set},
                                                              {"grab", Wish::grab},
                                                              {"move", Wish::move},
                                                              {"release", Wish::release},
                                                              {"show", Wish::show},
                                                              {"rewind", Wish::rewind},
                                                              {"save", Wish::save},
                                                              {"render", Wish::render},
                                                              {"lines", Wish::lines},
                                                              {"steer", Wish::steer},
                                                              {"seen", Wish::seen},
                                                              {"invite", Wish::invite},
                                                              {"place", Wish::place},
                                                              {"cells", Wish::cells}}};

std::optional<Wish> wish_of(const json& value) {
  if (!value.is_string()) return std::nullopt;
  for (const auto& [word, wish] : words)
    if (value.get_ref<const std::string&>() == word) return wish;
  return std::nullopt;
}

bool take(const json& message, const char* name, int& number) {
  const auto found = message.find(name);
  if (found == message.end() || !found->is_number_integer()) return false;
  const auto value = found->get<std::int64_t>();
  if (value < 0 || value > 2000000000) return false;
  number = int(value);
  return true;
}

bool take(const json& message, const char* name, double& number) {
  const auto found = message.find(name);
  if (found == message.end() || !found->is_number()) return false;
  number = found->get<double>();
  return std::isfinite(number);
}

bool take(const json& message, const char* name, Vector3d& place) {
  const auto found = message.find(name);
  if (found == message.end() || !found->is_array() || found->size() != 3) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(*found)[i].is_number()) return false;
    place[Eigen::Index(i)] = (*found)[i].get<double>();
  }
  return place.allFinite();
}

/// The message's own fields; how many there must be, or none where one is missing.
std::optional<std::size_t> take_fields(const json& text, Message& message) {
  const auto all = [](std::size_t count, bool there) { return there ? std::optional(count) : std::nullopt; };
  switch (message.wish) {
    case Wish::slower:
      return all(1, take(text, "value", message.value) && message.value >= 1 && message.value <= 64);
    case Wish::set:
      return all(2, take(text, "key", message.key) && take(text, "value", message.value));
    case Wish::grab:
      return all(3, take(text, "body", message.body) && take(text, "vertex", message.vertex) &&
                        take(text, "place", message.place));
    case Wish::place:
      return all(2, take(text, "obstacle", message.obstacle) && take(text, "place", message.place));
    case Wish::cells:
      return all(2, take(text, "body", message.body) && take(text, "cells", message.cells) && message.cells >= 1 &&
                        message.cells <= most_live_cells);
    case Wish::move:
      return all(1, take(text, "place", message.place));
    case Wish::show:
    case Wish::rewind:
    case Wish::seen:
      return all(1, take(text, "frame", message.frame));
    default:
      return 0;
  }
}

}  // namespace

std::optional<Message> decode_message(std::string_view text) {
  if (text.size() > longest_message) return std::nullopt;
  const json parsed = json::parse(text, nullptr, false);
  if (!parsed.is_object()) return std::nullopt;
  const auto word = parsed.find("wish");
  if (word == parsed.end()) return std::nullopt;
  const std::optional<Wish> wish = wish_of(*word);
  if (!wish) return std::nullopt;
  Message message{.wish = *wish};
  const std::optional<std::size_t> fields = take_fields(parsed, message);
  if (!fields || parsed.size() != *fields + 1) return std::nullopt;
  return message;
}

bool needs_steering(Wish wish) {
  return wish != Wish::lines && wish != Wish::steer && wish != Wish::seen && wish != Wish::invite;
}

}  // namespace umax
