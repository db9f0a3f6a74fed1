#include "tools/fit/csv_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/base/trimmed.h"

namespace umax {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

[[noreturn]] void fail(const std::string& where, const std::string& what, const std::string& value,
                       const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = where, .what = what, .value = value, .remedy = remedy});
}

/// Takes rows off the front of a text.
class CsvReader {
 public:
  CsvReader(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  bool at_end() const { return place_ >= text_.size(); }
  int line() const { return line_; }

  void skip_line() {
    while (!at_end() && !take_line_end()) ++place_;
  }
  bool at_comment() const { return text_[place_] == '#'; }

  CsvRow take_row() {
    CsvRow row{.line = line_};
    bool more = true;
    while (more) {
      row.fields.push_back(take_field());
      more = !at_end() && text_[place_] == ',';
      if (more) ++place_;
    }
    if (!at_end() && !take_line_end())
      fail(where(), "has text after a closing quote", std::string(1, text_[place_]), "double quotes within quotes");
    return row;
  }

 private:
  std::string where() const { return fmt::format("{}:{}", name_, line_); }

  bool take_line_end() {
    const char c = text_[place_];
    if (c != '\n' && c != '\r') return false;
    place_ += text_.substr(place_, 2) == "\r\n" ? 2 : 1;
    ++line_;
    return true;
  }

  std::string take_field() {
    while (!at_end() && (text_[place_] == ' ' || text_[place_] == '\t')) ++place_;
    if (!at_end() && text_[place_] == '"') return take_quoted();
    const std::size_t end = std::min(text_.find_first_of(",\r\n", place_), text_.size());
    const std::string field(trimmed(text_.substr(place_, end - place_)));
    place_ = end;
    return field;
  }

  std::string take_quoted() {
    const std::string start = where();
    std::string field;
    for (++place_; !at_end(); ++place_) {
      if (text_[place_] == '"') {
        if (text_.substr(place_, 2) != "\"\"") {
          ++place_;
          while (!at_end() && (text_[place_] == ' ' || text_[place_] == '\t')) ++place_;
          return std::string(trimmed(field));
        }
        ++place_;
      }
      if (text_[place_] == '\n') ++line_;
      field += text_[place_];
    }
    fail(start, "has a quote that never ends", "", "close it, or leave quotes out");
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t place_ = 0;
  int line_ = 1;
};

bool is_blank(const CsvRow& row) {
  return std::all_of(row.fields.begin(), row.fields.end(), [](const std::string& field) { return field.empty(); });
}

}  // namespace

CsvTable parse_csv(std::string_view text, const std::string& name) {
  if (text.substr(0, byte_order_mark.size()) == byte_order_mark) text.remove_prefix(byte_order_mark.size());
  const auto is_control = [](char c) { return c >= 0 && c < ' ' && c != '\t' && c != '\n' && c != '\r'; };
  if (std::any_of(text.begin(), text.end(), is_control))
    fail(name, "is no text file", "", "give comma-separated values; a spreadsheet saves them as CSV");
  CsvTable table;
  for (CsvReader reader(text, name); !reader.at_end();) {
    if (reader.at_comment()) {
      reader.skip_line();
      continue;
    }
    CsvRow row = reader.take_row();
    if (is_blank(row)) continue;
    const std::string where = fmt::format("{}:{}", name, row.line);
    if (table.header.fields.empty()) {
      if (row.fields.size() == 1 && row.fields[0].find_first_of(";\t") != std::string::npos)
        fail(where, "does not separate its columns by commas", row.fields[0],
             "save it with commas between columns and points in numbers, as in stretch [%],force [N]");
      table.header = std::move(row);
      continue;
    }
    if (row.fields.size() != table.header.fields.size())
      fail(where, fmt::format("needs {} fields as the header has", table.header.fields.size()),
           std::to_string(row.fields.size()), "write numbers with points, not commas, and leave no field out");
    table.rows.push_back(std::move(row));
  }
  if (table.header.fields.empty()) fail(name, "is empty", "", "give a header such as stretch [%],force [N] and rows");
  return table;
}

}  // namespace umax
