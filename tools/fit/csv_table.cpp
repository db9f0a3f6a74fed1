#include "tools/fit/csv_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "core/base/trimmed.h"

namespace umax {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

[[noreturn]] void fail(const std::string& where, const std::string& what, const std::string& value,
                       const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = where, .what = what, .value = value, .remedy = remedy});
}

/// What separates the columns of the first line that is no comment and not empty.
char separator_of(std::string_view text) {
  constexpr std::string_view separators = ",;\t";
  std::array<int, 3> counts{};
  bool quoted = false, comment = false, any = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool line_end = (c == '\n' || c == '\r') && !quoted;
    if (line_end && any) break;
    if (i == 0 || text[i - 1] == '\n' || text[i - 1] == '\r') comment = c == '#' && !quoted;
    if (line_end || comment) continue;
    if (c == '"') quoted = !quoted;
    const std::size_t kind = separators.find(c);
    if (kind != separators.npos && !quoted) ++counts[kind];
    any = any || (c != ' ' && kind == separators.npos);
  }
  return separators[std::size_t(std::max_element(counts.begin(), counts.end()) - counts.begin())];
}

/// Takes rows off the front of a text.
class CsvReader {
 public:
  CsvReader(std::string_view text, char separator, const std::string& name)
      : text_(text), separator_(separator), name_(name) {}

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
      more = !at_end() && text_[place_] == separator_;
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

  void skip_blanks() {
    while (!at_end() && (text_[place_] == ' ' || (text_[place_] == '\t' && separator_ != '\t'))) ++place_;
  }

  std::string take_field() {
    skip_blanks();
    if (!at_end() && text_[place_] == '"') return take_quoted();
    const std::size_t end = std::min(text_.find_first_of(std::string("\r\n") + separator_, place_), text_.size());
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
          skip_blanks();
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
  char separator_ = ',';
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
  CsvTable table{.separator = separator_of(text)};
  for (CsvReader reader(text, table.separator, name); !reader.at_end();) {
    if (reader.at_comment()) {
      reader.skip_line();
      continue;
    }
    CsvRow row = reader.take_row();
    if (is_blank(row)) continue;
    const std::string where = fmt::format("{}:{}", name, row.line);
    if (table.header.fields.empty()) {
      while (row.fields.back().empty()) row.fields.pop_back();
      table.header = std::move(row);
      continue;
    }
    while (row.fields.size() > table.header.fields.size() && row.fields.back().empty()) row.fields.pop_back();
    if (row.fields.size() != table.header.fields.size())
      fail(where, fmt::format("needs {} fields as the header has", table.header.fields.size()),
           std::to_string(row.fields.size()),
           table.separator == ',' ? "write numbers with points, not commas, and leave no field out"
                                  : "leave no field out");
    table.rows.push_back(std::move(row));
  }
  if (table.header.fields.empty()) fail(name, "is empty", "", "give a header such as stretch [%],force [N] and rows");
  return table;
}

bool take_decimal_commas(CsvTable& table) {
  if (table.separator == ',') return false;
  bool any = false;
  for (CsvRow& row : table.rows)
    for (std::string& field : row.fields) {
      const std::size_t comma = field.find(',');
      const bool is_decimal = comma != field.npos && field.find_first_not_of("0123456789,+-eE") == field.npos &&
                              std::count(field.begin(), field.end(), ',') == 1;
      if (is_decimal) field[comma] = '.';
      any = any || is_decimal;
    }
  return any;
}

}  // namespace umax
