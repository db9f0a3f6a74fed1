// One browser that watches a session: its WebSocket, what waits to be sent on it, and which pictures it has drawn.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "tools/live/messages.h"

namespace umax {

class Watcher;

/// Who hears of watchers; called on the thread that they live on.
struct WatcherEars {
  std::function<void(const std::shared_ptr<Watcher>&)> came, left;
  std::function<void(const std::shared_ptr<Watcher>&, const Message&)> wished;
};

/// A browser that watches.
class Watcher : public std::enable_shared_from_this<Watcher> {
 public:
  /// ears: outlives it.
  Watcher(const WatcherEars& ears, boost::asio::ip::tcp::socket socket) : ears_(ears), stream_(std::move(socket)) {}
  /// Answers the request for a WebSocket, and listens from then on.
  void start(const boost::beast::http::request<boost::beast::http::empty_body>& request);
  /// Sends a text as soon as those before it are gone; who takes none is sent away.
  void send(const std::string& text);
  /// Sends a picture once the browser has drawn most of those before, unless the next one comes first.
  void show(const std::shared_ptr<const std::string>& picture);
  /// Other meshes from now on, as hello tells.
  void begin_anew(const std::string& hello);
  void end() { close(boost::beast::websocket::close_code::going_away); }

 private:
  void read();
  void on_message(std::string_view text);
  void write_next();
  void close(boost::beast::websocket::close_code code);
  void leave();

  const WatcherEars& ears_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  boost::beast::flat_buffer buffer_;
  std::deque<std::string> texts_;
  std::shared_ptr<const std::string> next_, writing_picture_;
  std::deque<std::uint32_t> in_flight_;
  std::string writing_text_;
  bool is_writing_ = false, is_open_ = false, is_closing_ = false;
};

}  // namespace umax
