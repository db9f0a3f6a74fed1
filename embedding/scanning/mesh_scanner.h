// Walks through the bytes of a mesh file: words, numbers and raw blocks; what is missing or wrong is an error with the
// place in the file.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace umax {

class MeshScanner {
 public:
  /// The text must outlive the scanner. `what`: what the text is, for messages, where it is not the whole file.
  MeshScanner(const std::filesystem::path& path, std::string_view text, std::string what = {})
      : path_(path), text_(text), what_(std::move(what)) {}

  bool at_end();                          // nothing but white space follows
  std::string_view word();                // the next word; throws at the end
  std::string_view line();                // the rest of this line, without its end; empty at the end
  std::string_view peek();                // the next word, which stays; empty at the end
  std::string_view bytes(std::size_t n);  // the next n bytes
  long long integer(const char* meaning);
  double number(const char* meaning);  // also nan and inf

  /// Steps over the end of a line, which stands before raw bytes.
  void skip_line_end();

  /// Steps behind the next line that is just `end`; throws if there is none.
  void skip_past(std::string_view end);

  /// Whether `count` things of at least `bytes_each` bytes fit into what follows.
  bool has_room(long long count, long long bytes_each) const;
  /// Throws unless `count` things of at least `bytes_each` bytes fit into what follows. Call before taking memory.
  void require_room(long long count, long long bytes_each, const char* things) const;

  /// Error (bad_data) at this place.
  [[noreturn]] void refuse(const std::string& what, const std::string& value = {},
                           const std::string& remedy = "the file is truncated or damaged: export it again") const;

 private:
  void skip_space();

  std::filesystem::path path_;
  std::string_view text_;
  std::string what_;
  std::size_t at_ = 0;
};

}  // namespace umax
