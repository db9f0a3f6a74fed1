// A client of HTTP and WebSockets that says what no browser would: bytes on a socket, each wait bounded.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

namespace umax::test {

class RawClient {
 public:
  explicit RawClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    timeval patience{.tv_sec = 5, .tv_usec = 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    sockaddr_in there{};
    there.sin_family = AF_INET;
    there.sin_port = htons(std::uint16_t(port));
    there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0;
  }
  ~RawClient() { ::close(socket_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool is_connected() const { return connected_; }

  bool send(const std::string& bytes) {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t n = ::send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return false;
      sent += std::size_t(n);
    }
    return true;
  }

  /// An HTTP answer: its head and body. Empty: the connection was closed, or nothing came.
  std::string answer() {
    while (waiting_.find("\r\n\r\n") == std::string::npos)
      if (!more()) return std::exchange(waiting_, {});
    const std::size_t head = waiting_.find("\r\n\r\n") + 4;
    std::size_t length = 0;
    if (const std::size_t at = waiting_.find("Content-Length: "); at < head)
      length = std::stoul(waiting_.substr(at + 16));
    while (waiting_.size() < head + length)
      if (!more()) break;
    std::string text = waiting_.substr(0, head + length);
    waiting_.erase(0, head + length);
    return text;
  }

  std::string get(const std::string& target, const std::string& headers) {
    send("GET " + target + " HTTP/1.1\r\n" + headers + "\r\n");
    return answer();
  }

  /// Whether a WebSocket was granted.
  bool upgrade(const std::string& headers, const std::string& target = "/live") {
    send("GET " + target +
         " HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n" +
         headers + "\r\n");
    return answer().starts_with("HTTP/1.1 101");
  }

  bool say(const std::string& text, unsigned opcode = 1) {
    std::string frame(1, char(0x80 | opcode));
    if (text.size() < 126) {
      frame += char(0x80 | text.size());
    } else {
      frame += char(0x80 | 126);
      frame += char(text.size() >> 8), frame += char(text.size() & 255);
    }
    frame += std::string(4, '\0');  // a mask that changes nothing
    return send(frame + text);
  }

  struct Frame {
    unsigned opcode = 0;  // 1 text, 2 binary, 8 close
    std::string bytes;
  };
  /// The next frame; none: the connection is gone, or nothing came.
  std::optional<Frame> hear() {
    if (!have(2)) return std::nullopt;
    Frame frame{.opcode = unsigned(waiting_[0]) & 15, .bytes = {}};
    std::size_t length = unsigned(waiting_[1]) & 127, head = 2;
    const std::size_t wide = length == 126 ? 2 : length == 127 ? 8 : 0;
    if (!have(2 + wide)) return std::nullopt;
    if (wide > 0) {
      length = 0;
      for (std::size_t i = 0; i < wide; ++i) length = length << 8 | static_cast<unsigned char>(waiting_[2 + i]);
      head += wide;
    }
    if (!have(head + length)) return std::nullopt;
    frame.bytes = waiting_.substr(head, length);
    waiting_.erase(0, head + length);
    return frame;
  }

  /// Hears frames until one is a text with these words, or a close, or the time is over. Pictures on the way are acknowledged.
  std::string hear_text(const std::string& words, double seconds = 5) {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < seconds) {
      const std::optional<Frame> frame = hear();
      if (!frame || frame->opcode == 8) return {};
      if (frame->opcode == 2) acknowledge(frame->bytes);
      if (frame->opcode == 1 && frame->bytes.find(words) != std::string::npos) return frame->bytes;
    }
    return {};
  }

  /// Tells umax live that a picture has been drawn.
  void acknowledge(const std::string& picture) {
    std::uint32_t number = 0;
    std::memcpy(&number, picture.data() + 4, sizeof number);
    say("{\"wish\":\"seen\",\"frame\":" + std::to_string(number) + "}");
  }

  /// Whether the server closes before this many frames have come.
  bool is_closed(int frames = 200) {
    for (int i = 0; i < frames; ++i) {
      const std::optional<Frame> frame = hear();
      if (!frame || frame->opcode == 8) return true;
    }
    return false;
  }

 private:
  bool more() {
    char bytes[65536];
    const ssize_t n = ::recv(socket_, bytes, sizeof bytes, 0);
    if (n > 0) waiting_.append(bytes, std::size_t(n));
    return n > 0;
  }
  bool have(std::size_t count) {
    while (waiting_.size() < count)
      if (!more()) return false;
    return true;
  }

  int socket_ = -1;
  bool connected_ = false;
  std::string waiting_;
};

}  // namespace umax::test
