#include "tools/trials/variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/base/error.h"
#include "core/base/trimmed.h"
#include "tools/trials/trial_names.h"

namespace umax {
namespace {

[[noreturn]] void refuse(const std::string& where, const std::string& what, const std::string& value,
                         const std::string& remedy) {
  throw Error(Fault::usage, {.where = where, .what = what, .value = value, .remedy = remedy});
}

constexpr const char* example = "write for example --vary body.figure.limit.stretch=5%,10%,20%";

/// Parts of a list between commas that stand in no bracket and no quote.
std::vector<std::string> split_list(const std::string& list, const std::string& where) {
  std::vector<std::string> parts(1);
  std::string open;  // what closes, innermost last
  for (const char c : list) {
    const bool quoted = !open.empty() && (open.back() == '"' || open.back() == '\'');
    if (!open.empty() && c == open.back())
      open.pop_back();
    else if (!quoted && (c == '"' || c == '\''))
      open += c;
    else if (!quoted && (c == '[' || c == '{'))
      open += c == '[' ? ']' : '}';
    if (c == ',' && open.empty())
      parts.emplace_back();
    else
      parts.back() += c;
  }
  if (!open.empty()) refuse(where, fmt::format("a {} is missing", open.back()), list, example);
  for (std::string& part : parts) part = std::string(trimmed(part));
  return parts;
}

/// "stretch 5%"; a material says by itself what it is.
std::string label_of(const std::string& key, std::string value) {
  if (key != "preset") return key + " " + value;
  std::replace(value.begin(), value.end(), '_', ' ');
  return value;
}

SceneVariant variant_of(const std::vector<Variation>& variations, const std::vector<std::string>& keys, int index) {
  SceneVariant variant;
  for (auto variation = variations.rbegin(); variation != variations.rend(); ++variation) {
    const int count = int(variation->values.size());
    variant.values.insert(variant.values.begin(), variation->values[std::size_t(index % count)]);
    index /= count;
  }
  for (std::size_t i = 0; i < variations.size(); ++i) {
    for (const std::string& key : variations[i].keys) variant.settings.push_back({key, variant.values[i]});
    const std::string key = short_key(variations[i].keys.front(), keys);
    variant.name += (i == 0 ? "" : ",") + folder_name(key + "=" + variant.values[i]);
    variant.label += (i == 0 ? "" : ", ") + label_of(key, variant.values[i]);
  }
  return variant;
}

/// Values that differ only in what a folder's name leaves out get a number.
void make_names_unique(std::vector<SceneVariant>& variants) {
  std::map<std::string, int> uses;
  for (SceneVariant& variant : variants)
    if (const int use = ++uses[variant.name]; use > 1) variant.name += fmt::format("#{}", use);
}

}  // namespace

Variation parse_variation(const std::string& text) {
  const std::string where = "--vary " + text;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || trimmed(text.substr(0, equals)).empty())
    refuse("--vary", "needs KEY=A,B,C", text, example);
  Variation variation{.keys = {std::string(trimmed(text.substr(0, equals)))},
                      .values = split_list(text.substr(equals + 1), where)};
  for (auto value = variation.values.begin(); value != variation.values.end(); ++value) {
    if (value->empty()) refuse(where, "has an empty value", "", example);
    if (std::find(variation.values.begin(), value, *value) != value)
      refuse(where, "has a value twice", *value, "leave one out");
  }
  return variation;
}

std::vector<SceneVariant> combinations(const std::vector<Variation>& variations) {
  if (variations.empty()) refuse("--vary", "nothing is varied", "", example);
  std::vector<std::string> keys;
  long long count = 1;
  for (const Variation& variation : variations) {
    for (const std::string& key : variation.keys) {
      if (std::find(keys.begin(), keys.end(), key) != keys.end())
        refuse("--vary " + key, "is varied twice", "", "list all its values behind one --vary");
      keys.push_back(key);
    }
    count *= (long long)(variation.values.size());
    if (count > most_variants)
      refuse("--vary", fmt::format("makes at most {} variants", most_variants), std::to_string(count) + " or more",
             "vary fewer keys at once, or give fewer values");
  }
  std::vector<SceneVariant> variants;
  for (int i = 0; i < int(count); ++i) variants.push_back(variant_of(variations, keys, i));
  make_names_unique(variants);
  return variants;
}

}  // namespace umax
