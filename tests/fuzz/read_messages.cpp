// What a browser tells a live session: whatever it says, a message is one that the session can be asked for.
#include <cmath>

#include "tests/fuzz/fuzz_target.h"
#include "tools/live/messages.h"

namespace umax::fuzz {

void read_messages(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::string_view line = bytes.substr(0, bytes.find('\n'));
    bytes.remove_prefix(std::min(line.size() + 1, bytes.size()));
    const auto message = decode_message(line);
    if (!message) continue;
    require(message->key >= 0 && message->body >= 0 && message->vertex >= 0 && message->obstacle >= 0 &&
                message->frame >= 0,
            "numbers in messages are not negative");
    require(std::isfinite(message->value) && message->place.allFinite(), "values in messages are finite");
    require(message->wish != Wish::slower || (message->value >= 1 && message->value <= 64),
            "a pace is one that there is");
  }
}

}  // namespace umax::fuzz
