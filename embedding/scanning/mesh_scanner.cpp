#include "embedding/scanning/mesh_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "embedding/scanning/file_checks.h"

namespace umax {
namespace {

constexpr std::string_view white_space = " \t\r\n\v\f";

}  // namespace

void MeshScanner::skip_space() {
  at_ = std::min(text_.find_first_not_of(white_space, at_), text_.size());
}

bool MeshScanner::at_end() {
  skip_space();
  return at_ == text_.size();
}

std::string_view MeshScanner::peek() {
  skip_space();
  return text_.substr(at_, std::min(text_.find_first_of(white_space, at_), text_.size()) - at_);
}

std::string_view MeshScanner::word() {
  const std::string_view next = peek();
  if (next.empty()) refuse("ends too early");
  at_ += next.size();
  return next;
}

std::string_view MeshScanner::line() {
  const std::size_t end = std::min(text_.find('\n', at_), text_.size());
  std::string_view rest = text_.substr(at_, end - at_);
  at_ = std::min(end + 1, text_.size());
  if (rest.ends_with('\r')) rest.remove_suffix(1);
  return rest;
}

std::string_view MeshScanner::bytes(std::size_t n) {
  if (n > text_.size() - at_) refuse("ends too early", fmt::format("{} of {} bytes", text_.size() - at_, n));
  at_ += n;
  return text_.substr(at_ - n, n);
}

long long MeshScanner::integer(const char* meaning) {
  const std::string_view text = word();
  long long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    refuse(fmt::format("{} must be an integer", meaning), fmt::format("\"{}\"", text.substr(0, 40)));
  return value;
}

double MeshScanner::number(const char* meaning) {
  std::string_view text = word();
  const std::string_view whole = text;
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool tiny = error == std::errc::result_out_of_range && text.find("e-") != text.npos;
  if (tiny) return 0;
  if (error != std::errc() || end != text.data() + text.size())
    refuse(fmt::format("{} must be a number", meaning), fmt::format("\"{}\"", whole.substr(0, 40)));
  return value;
}

void MeshScanner::skip_line_end() {
  const std::string_view rest = line();
  if (rest.find_first_not_of(white_space) != rest.npos)
    refuse("has something before the end of the line", fmt::format("\"{}\"", rest.substr(0, 40)));
}

void MeshScanner::skip_past(std::string_view end) {
  for (std::size_t from = at_;;) {
    const std::size_t found = text_.find(end, from);
    if (found == text_.npos) refuse(fmt::format("has no \"{}\"", end));
    from = found + end.size();
    const bool starts_line = found == 0 || text_[found - 1] == '\n';
    if (!starts_line || (from < text_.size() && white_space.find(text_[from]) == white_space.npos)) continue;
    at_ = from;
    return;
  }
}

bool MeshScanner::has_room(long long count, long long bytes_each) const {
  const auto room = (long long)(text_.size() - at_) + 1;  // the last number of a text needs no space after it
  return count >= 0 && count <= room / bytes_each;
}

void MeshScanner::require_room(long long count, long long bytes_each, const char* things) const {
  if (!has_room(count, bytes_each))
    refuse(fmt::format("promises {} {}", count, things), fmt::format("{} bytes", text_.size() - at_));
}

void MeshScanner::refuse(const std::string& what, const std::string& value, const std::string& remedy) const {
  const auto line_number = 1 + std::count(text_.begin(), text_.begin() + std::ptrdiff_t(at_), '\n');
  const std::string place = what_.empty() ? fmt::format(":{}", line_number) : ": " + what_;
  refuse_mesh(path_.string() + place, what, value, remedy);
}

}  // namespace umax
