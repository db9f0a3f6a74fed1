#include "embedding/cameras/usda_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <set>

#include "embedding/cameras/camera_readers.h"

namespace umax::cameras {
namespace {

constexpr int deepest = 200;  // of prims and lists in each other

class Parser {
 public:
  Parser(const std::filesystem::path& path, std::string_view text) : path_(path), text_(text) {}

  UsdPrim file() {
    UsdPrim root;
    skip_space();
    if (peek() == '(') root.metadata = metadata();
    while (!at_end()) statement(root, 0);
    return root;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + std::ptrdiff_t(std::min(at_, text_.size())), '\n');
    refuse(path_, "is damaged USD: " + what, "line " + std::to_string(line));
  }

  // --- characters and words
  void skip_space() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#')
        at_ = std::min(text_.find('\n', at_), text_.size());
      else if (std::isspace(static_cast<unsigned char>(c)) || c == ';')
        ++at_;
      else
        return;
    }
  }
  bool at_end() {
    skip_space();
    return at_ == text_.size();
  }
  char peek() {
    skip_space();
    if (at_ == text_.size()) fail("it ends too early");
    return text_[at_];
  }
  bool take(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  void need(char c) {
    if (!take(c)) fail(std::string("'") + c + "' is missing");
  }
  /// Letters, digits and what stands in names and numbers; empty before anything else.
  std::string word() {
    skip_space();
    const std::size_t start = at_;
    const auto belongs = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) || static_cast<unsigned char>(c) >= 0x80 ||
             std::string_view("_:.+-!|").find(c) != std::string_view::npos;
    };
    while (at_ < text_.size() && belongs(text_[at_])) ++at_;
    return std::string(text_.substr(start, at_ - start));
  }
  /// A text in quotes, of one or of three kinds of them.
  std::string quoted() {
    const char quote = peek();
    const std::string three(3, quote);
    const std::string end = text_.substr(at_, 3) == three ? three : std::string(1, quote);
    at_ += end.size();
    std::string text;
    while (text_.substr(std::min(at_, text_.size()), end.size()) != end) {
      if (at_ < text_.size() && text_[at_] == '\\') ++at_;
      if (at_ >= text_.size()) fail("a text does not end");
      text += text_[at_++];
    }
    at_ += end.size();
    return text;
  }
  /// "@file@" or "<path>".
  std::string enclosed(char end) {
    const std::size_t start = ++at_, stop = text_.find(end, start);
    if (stop == text_.npos) fail("a path does not end");
    at_ = stop + 1;
    return std::string(text_.substr(start, stop - start));
  }

  // --- values
  void value(UsdValue& to, int depth) {
    if (depth > deepest) fail("too many brackets");
    const char c = peek();
    if (c == '(' || c == '[') {
      ++at_;
      for (const char end = c == '(' ? ')' : ']'; !take(end); take(',')) value(to, depth + 1);
    } else if (c == '"' || c == '\'') {
      keep(quoted(), to);
    } else if (c == '@' || c == '<') {
      keep(enclosed(c == '@' ? '@' : '>'), to);
      if (c == '@' && at_ < text_.size() && text_[at_] == '<') enclosed('>');  // of what is in that file
    } else if (c == '{') {
      dictionary(depth + 1);
    } else {
      number_or_word(to);
    }
  }
  void number_or_word(UsdValue& to) {
    const std::string text = word();
    if (text.empty()) fail("a value is missing");
    double number = 0;
    const char* start = text.data() + (text[0] == '+' ? 1 : 0);
    const auto [end, error] = std::from_chars(start, text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size())
      keep(text, to);
    else if (is_kept_)
      to.numbers.push_back(number);
  }
  void keep(const std::string& text, UsdValue& to) const {
    if (is_kept_) to.words.push_back(text);
  }
  /// Passes it by.
  void dictionary(int depth) {
    if (depth > deepest) fail("too many brackets");
    need('{');
    while (!take('}')) {
      UsdValue ignored;
      if (std::string_view("=,:").find(peek()) != std::string_view::npos)
        ++at_;
      else
        value(ignored, depth + 1);
    }
  }
  std::map<double, UsdValue> samples() {
    std::map<double, UsdValue> found;
    need('{');
    while (!take('}')) {
      UsdValue time, sample;
      time_of_sample(time);
      value(sample, 0);
      if (is_kept_ && time.numbers.size() != 1) fail("a sample has no time");
      if (is_kept_) found[time.numbers[0]] = sample;
      take(',');
    }
    return found;
  }
  /// Its colon ends it, which words have, too.
  void time_of_sample(UsdValue& time) {
    skip_space();
    const std::size_t end = text_.find(':', at_);
    if (end == text_.npos) fail("a sample has no time");
    Parser part(path_, text_.substr(0, end));
    part.at_ = at_;
    part.is_kept_ = is_kept_;
    part.number_or_word(time);
    at_ = end + 1;
  }
  std::map<std::string, UsdValue> metadata() {
    std::map<std::string, UsdValue> found;
    need('(');
    while (!take(')')) {
      if (peek() == '"' || peek() == '\'') {  // a comment
        quoted();
        continue;
      }
      std::string name = word();
      if (name.empty()) fail("a name is missing");
      // "prepend references = …"
      while (peek() != '=' && peek() != ')') {
        const std::string next = word();
        if (next.empty()) break;
        name = next;
      }
      if (take('=')) value(found[name], 0);
      take(',');
    }
    return found;
  }

  // --- what a prim holds
  void statement(UsdPrim& parent, int depth) {
    if (depth > deepest) fail("too many prims in each other");
    const std::string first = word();
    if (first.empty()) fail(std::string("'") + peek() + "' is not expected");
    if (first == "def" || first == "over" || first == "class")
      prim(parent, depth);
    else if (first == "variantSet")
      pass_variants();
    else
      attribute(first, parent);
  }
  void prim(UsdPrim& parent, int depth) {
    UsdPrim child;
    if (peek() != '"') child.type = word();
    if (peek() != '"') fail("a prim has no name");
    child.name = quoted();
    if (peek() == '(') metadata();
    need('{');
    while (!take('}')) statement(child, depth + 1);
    parent.children.push_back(std::move(child));
  }
  void pass_variants() {
    quoted();
    need('=');
    int open = 0;
    do {
      const char c = peek();
      if (c == '"' || c == '\'') {
        quoted();
        continue;
      }
      open += c == '{' ? 1 : c == '}' ? -1 : 0;
      ++at_;
    } while (open > 0);
  }
  /// "uniform token[] xformOpOrder = [...]", whose first word has been read; without a value it ends with its line.
  void attribute(const std::string& first, UsdPrim& prim) {
    std::vector<std::string> words{first};
    while (at_ < text_.size() && std::string_view("=(}\n#;").find(text_[at_]) == std::string_view::npos) {
      if (std::isspace(static_cast<unsigned char>(text_[at_])) || text_[at_] == '[' || text_[at_] == ']') {
        ++at_;
        continue;
      }
      words.push_back(word());
      if (words.back().empty()) fail(std::string("'") + text_[at_] + "' is not expected");
    }
    static constexpr std::string_view of_samples = ".timeSamples";
    std::string name = words.back();
    const bool has_samples = name.ends_with(of_samples);
    if (has_samples) name.resize(name.size() - of_samples.size());
    UsdAttribute read;
    read.type = words.size() > 1 ? words[words.size() - 2] : "";
    is_kept_ = is_wanted(name);
    if (!at_end() && take('=')) {
      if (has_samples)
        read.samples = samples();
      else
        value(read.value, 0);
    }
    if (is_kept_) merge(std::move(read), prim.attributes[name]);
    is_kept_ = true;
    if (!at_end() && peek() == '(') metadata();
  }
  /// The points of meshes, and all else that is large, are not.
  static bool is_wanted(const std::string& name) {
    static const std::set<std::string> of_cameras{"focalLength", "verticalAperture", "projection",
                                                  "horizontalApertureOffset", "verticalApertureOffset"};
    return name.starts_with("xformOp") || of_cameras.count(name) > 0;
  }
  /// An attribute may have samples in one statement and a value in another.
  static void merge(UsdAttribute read, UsdAttribute& into) {
    into.type = read.type;
    if (!read.samples.empty())
      into.samples = std::move(read.samples);
    else
      into.value = std::move(read.value);
  }

  const std::filesystem::path& path_;
  std::string_view text_;
  std::size_t at_ = 0;
  bool is_kept_ = true;  // the value that is being read
};

}  // namespace

UsdPrim parse_usda(const std::filesystem::path& path, std::string_view text) {
  return Parser(path, text).file();
}

}  // namespace umax::cameras
