#include "tools/live/server.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cstring>
#include <deque>
#include <map>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "tools/live/access.h"
#include "tools/live/answers.h"

namespace umax {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;
using Code = beast::error_code;

constexpr int most_connections = 64, most_watchers = 8;
constexpr std::size_t most_texts = 256;    // that wait for a watcher; one that takes none is sent away
constexpr std::size_t most_in_flight = 2;  // pictures that a browser has not drawn yet
constexpr auto http_patience = std::chrono::seconds(30);

class Server;

/// A browser that watches.
class Watcher : public std::enable_shared_from_this<Watcher> {
 public:
  Watcher(Server& server, Tcp::socket socket) : server_(server), stream_(std::move(socket)) {}
  void start(const Request& request);
  void send(const std::string& text);
  void show(const std::shared_ptr<const std::string>& picture);
  void begin_anew(const std::string& hello);
  void end() { close(websocket::close_code::going_away); }

 private:
  void read();
  void on_message(std::string_view text);
  void write_next();
  void close(websocket::close_code code);
  void leave();

  Server& server_;
  websocket::stream<beast::tcp_stream> stream_;
  beast::flat_buffer buffer_;
  std::deque<std::string> texts_;
  std::shared_ptr<const std::string> next_, writing_picture_;
  std::deque<std::uint32_t> in_flight_;
  std::string writing_text_;
  bool is_writing_ = false, is_open_ = false, is_closing_ = false;
};

/// A connection that asks for files, and may become a watcher.
class Visit : public std::enable_shared_from_this<Visit> {
 public:
  Visit(Server& server, Tcp::socket socket);
  ~Visit();
  void read();

 private:
  void answer();

  Server& server_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{8192};
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::optional<Response> response_;
};

class Server {
 public:
  Server(Session& session, Recording& recording, const ServeOptions& options);
  void run();

  Response answer(const Request& request);
  bool may_watch(const Request& request) const;
  void come(const std::shared_ptr<Watcher>& watcher);
  void leave(const std::shared_ptr<Watcher>& watcher);
  void take(const std::shared_ptr<Watcher>& watcher, const Message& message);

  int connections = 0;

 private:
  void listen();
  void accept();
  void look();
  void tell_roles();
  std::string address() const;
  LiveNews news();

  Session& session_;
  ServeOptions options_;
  asio::io_context io_{1};
  Tcp::acceptor acceptor_{io_};
  asio::steady_timer timer_{io_};
  Access access_ = new_access();
  std::map<std::string, std::string> files_ = page_files();
  std::vector<std::shared_ptr<Watcher>> watchers_;  // the first that came first
  std::shared_ptr<Watcher> steers_;
  std::string hello_;
  LiveLoop loop_;  // last: it ends first
};

// ---- watchers

void Watcher::start(const Request& request) {
  stream_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  stream_.read_message_max(longest_message);
  stream_.auto_fragment(false);
  stream_.async_accept(request, [self = shared_from_this()](Code code) {
    if (code) return self->leave();
    self->is_open_ = true;
    self->server_.come(self);
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
    server_.take(shared_from_this(), *message);
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
  server_.leave(shared_from_this());
}

// ---- visits

Visit::Visit(Server& server, Tcp::socket socket) : server_(server), stream_(std::move(socket)) {
  ++server_.connections;
}
Visit::~Visit() {
  --server_.connections;
}

void Visit::read() {
  parser_.emplace();
  parser_->header_limit(8192);
  parser_->body_limit(0);
  stream_.expires_after(http_patience);
  http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](Code code, std::size_t) {
    if (!code) self->answer();
  });
}

void Visit::answer() {
  const Request request = parser_->release();
  if (websocket::is_upgrade(request) && server_.may_watch(request)) {
    stream_.expires_never();
    std::make_shared<Watcher>(server_, stream_.release_socket())->start(request);
    return;
  }
  response_.emplace(server_.answer(request));
  stream_.expires_after(http_patience);
  http::async_write(stream_, *response_, [self = shared_from_this()](Code code, std::size_t) {
    if (!code && self->response_->keep_alive()) self->read();
  });
}

// ---- the server

Asked asked_by(const Request& request) {
  const auto header = [&](http::field field) { return std::string_view(request[field].data(), request[field].size()); };
  return {.method = {request.method_string().data(), request.method_string().size()},
          .target = {request.target().data(), request.target().size()},
          .host = header(http::field::host),
          .origin = header(http::field::origin),
          .cookies = header(http::field::cookie)};
}

Response make_response(const Request& request, const Answer& answer) {
  Response response{http::status(answer.status), request.version()};
  const std::string host(request[http::field::host]);
  response.set(http::field::content_type, answer.type);
  response.set(http::field::cache_control, "no-store");
  response.set("Content-Security-Policy", content_policy(is_local_host(host) ? host : "127.0.0.1"));
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  if (!answer.set_cookie.empty()) response.set(http::field::set_cookie, answer.set_cookie);
  response.keep_alive(request.keep_alive());
  response.body() = answer.body;
  response.prepare_payload();
  return response;
}

Server::Server(Session& session, Recording& recording, const ServeOptions& options)
    : session_(session),
      options_(options),
      hello_(hello_text(session, options.keep)),
      loop_((listen(), session), recording, news(), options.slower) {}

void Server::listen() {
  try {
    const Tcp::endpoint here(asio::ip::address_v4::loopback(), static_cast<unsigned short>(options_.port));
    acceptor_.open(here.protocol());
    acceptor_.set_option(asio::socket_base::reuse_address(true));
    acceptor_.bind(here);
    acceptor_.listen();
  } catch (const boost::system::system_error& error) {
    throw Error(Fault::unavailable, {.where = fmt::format("127.0.0.1:{}", options_.port),
                                     .what = "cannot be listened on (" + error.code().message() + ")",
                                     .remedy = "give another --port, or none: then a free one is taken"});
  }
}

// news come on the loop's thread and are told on the server's
LiveNews Server::news() {
  return {.picture =
              [this](const std::shared_ptr<const std::string>& picture) {
                asio::post(io_, [this, picture] {
                  for (const auto& watcher : std::vector(watchers_)) watcher->show(picture);
                });
              },
          .told =
              [this](const std::string& text) {
                asio::post(io_, [this, text] {
                  for (const auto& watcher : std::vector(watchers_)) watcher->send(text);
                });
              },
          .rebuilt =
              [this] {
                asio::post(io_, [this, hello = hello_text(session_, options_.keep)] {
                  hello_ = hello;
                  for (const auto& watcher : std::vector(watchers_)) watcher->begin_anew(hello_);
                });
              },
          .said = [this](const std::string& line) { asio::post(io_, [this, line] { options_.on_line(line); }); }};
}

void Server::run() {
  accept();
  look();
  options_.on_address(address(), true);
  io_.run();
  if (const std::exception_ptr failure = loop_.failure()) std::rethrow_exception(failure);
}

void Server::accept() {
  acceptor_.async_accept([this](Code code, Tcp::socket socket) {
    if (code == asio::error::operation_aborted) return;
    Code ignored;
    if (!code) socket.set_option(Tcp::no_delay(true), ignored);
    if (!code && connections + int(watchers_.size()) < most_connections)
      std::make_shared<Visit>(*this, std::move(socket))->read();
    accept();
  });
}

void Server::look() {
  if (options_.ends() || loop_.failure()) {
    acceptor_.close();
    for (const auto& watcher : std::vector(watchers_)) watcher->end();
    timer_.expires_after(std::chrono::milliseconds(200));
    timer_.async_wait([this](Code) { io_.stop(); });
    return;
  }
  timer_.expires_after(std::chrono::milliseconds(50));
  timer_.async_wait([this](Code code) {
    if (!code) look();
  });
}

std::string Server::address() const {
  return fmt::format("http://127.0.0.1:{}/?token={}", acceptor_.local_endpoint().port(), access_.token);
}

Response Server::answer(const Request& request) {
  const std::lock_guard lock(session_.other_meshes);
  const Answer answer = answer_to(asked_by(request), files_, session_.simulation, access_);
  if (answer.is_admission) options_.on_address(address(), false);
  return make_response(request, answer);
}

bool Server::may_watch(const Request& request) const {
  return umax::may_watch(asked_by(request), access_) && int(watchers_.size()) < most_watchers;
}

void Server::come(const std::shared_ptr<Watcher>& watcher) {
  watchers_.push_back(watcher);
  if (!steers_) steers_ = watcher;
  watcher->send(hello_);
  tell_roles();
  loop_.show_again();
}

void Server::leave(const std::shared_ptr<Watcher>& watcher) {
  const auto found = std::find(watchers_.begin(), watchers_.end(), watcher);
  if (found == watchers_.end()) return;
  watchers_.erase(found);
  if (steers_ == watcher) {
    loop_.post({.wish = Wish::release});
    steers_ = watchers_.empty() ? nullptr : watchers_.front();
  }
  tell_roles();
}

void Server::tell_roles() {
  for (const auto& watcher : std::vector(watchers_))
    watcher->send(role_text(watcher == steers_, int(watchers_.size())));
}

void Server::take(const std::shared_ptr<Watcher>& watcher, const Message& message) {
  if (message.wish == Wish::steer) {
    loop_.post({.wish = Wish::release});
    steers_ = watcher;
    tell_roles();
  } else if (message.wish == Wish::invite) {
    watcher->send(told_text("invite", address()));
  } else if (needs_steering(message.wish) && watcher != steers_) {
    watcher->send(told_text("error", "another browser steers: press Steer first"));
  } else {
    loop_.post(message);
  }
}

}  // namespace

void serve(Session& session, Recording& recording, const ServeOptions& options) {
  Server server(session, recording, options);
  server.run();
}

}  // namespace umax
