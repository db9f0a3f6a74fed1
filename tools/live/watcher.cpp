#include "tools/live/watcher.h"

#include <cstring>
#include <optional>
#include <string_view>

namespace umax {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Code = beast::error_code;

constexpr std::size_t most_texts = 256;    // that wait for a watcher
constexpr std::size_t most_in_flight = 2;  // pictures that a browser has not drawn yet

}  // namespace

void Watcher::start(const http::request<http::empty_body>& request) {
  stream_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  stream_.read_message_max(longest_message);
  stream_.auto_fragment(false);
  stream_.async_accept(request, [self = shared_from_this()](Code code) {
    if (code) return self->leave();
    self->is_open_ = true;
    self->ears_.came(self);
    self->read();
  });
}

void Watcher::read() {
  stream_.async_read(buffer_, [self = shared_from_this()](Code code, std::size_t) {
    if (code) return self->leave();
    const std::string text = beast::buffers_to_string(self->buffer_.data());
    self->buffer_.consume(self->buffer_.size());
    if (!self->stream_.got_text()) return self->close(websocket::close_code::unknown_data);
    self->on_message(text);
  });
}

void Watcher::on_message(std::string_view text) {
  const std::optional<Message> message = decode_message(text);
  if (!message) return close(websocket::close_code::policy_error);
  if (message->wish == Wish::seen) {
    while (!in_flight_.empty() && in_flight_.front() <= std::uint32_t(message->frame)) in_flight_.pop_front();
    write_next();
  } else {
    ears_.wished(shared_from_this(), *message);
  }
  if (!is_closing_) read();
}

void Watcher::send(const std::string& text) {
  if (texts_.size() >= most_texts) return close(websocket::close_code::try_again_later);
  texts_.push_back(text);
  write_next();
}

void Watcher::show(const std::shared_ptr<const std::string>& picture) {
  next_ = picture;  // in place of one that has waited too long
  write_next();
}

void Watcher::begin_anew(const std::string& hello) {
  next_ = nullptr;  // of meshes that are no more
  send(hello);
}

void Watcher::write_next() {
  if (!is_open_ || is_writing_ || is_closing_) return;
  const auto done = [self = shared_from_this()](Code code, std::size_t) {
    self->is_writing_ = false;
    if (!code) self->write_next();
  };
  if (!texts_.empty()) {
    is_writing_ = true;
    writing_text_ = std::move(texts_.front());
    texts_.pop_front();
    stream_.text(true);
    stream_.async_write(asio::buffer(writing_text_), done);
  } else if (next_ && in_flight_.size() < most_in_flight) {
    is_writing_ = true;
    writing_picture_ = std::exchange(next_, nullptr);
    std::uint32_t number = 0;
    std::memcpy(&number, writing_picture_->data() + 4, sizeof number);
    in_flight_.push_back(number);
    stream_.binary(true);
    stream_.async_write(asio::buffer(*writing_picture_), done);
  }
}

void Watcher::close(websocket::close_code code) {
  if (is_closing_) return;
  is_closing_ = true;
  if (is_open_ && !is_writing_)
    stream_.async_close(code, [self = shared_from_this()](Code) { self->leave(); });
  else
    leave();
}

void Watcher::leave() {
  is_closing_ = true;
  beast::get_lowest_layer(stream_).close();
  ears_.left(shared_from_this());
}

}  // namespace umax
