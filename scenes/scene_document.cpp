#include "scenes/scene_document.h"

#include <algorithm>
#include <utility>

#include "core/base/nearest_word.h"
#include "scenes/toml_text.h"

namespace umax {
namespace {

// Names go into file names, columns of steps.csv and --set.
bool is_name(const std::string& name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= 100 && std::all_of(name.begin(), name.end(), allowed);
}

void set_key(SceneValue& value, const std::string& key) {
  value.key = key;
  if (auto* array = std::get_if<SceneValue::Array>(&value.data))
    for (SceneValue& element : *array) set_key(element, key);
  if (auto* table = std::get_if<SceneValue::Table>(&value.data))
    for (auto& [name, element] : *table) set_key(element, key);
}

bool is_prefix(const SceneSection& section, const std::string& name) {
  const std::string start = name + ".";
  return std::any_of(section.keys.begin(), section.keys.end(),
                     [&](const SceneKey& key) { return key.name.compare(0, start.size(), start) == 0; });
}

Error unknown_key_error(const SourcePlace& place, const SceneSection& section, const std::string& thing,
                        const std::string& name) {
  const std::string full_name = section.key_prefix(thing) + name;
  // the same word in another section is closer than a similar one here
  std::string suggestion = section.key_prefix(thing) + nearest_key(name, section.key_names());
  const int distance = edit_distance(section.key_prefix(thing) + name, suggestion);
  for (const SceneSection& other : scene_sections())
    if (distance > 2 && !section.find(name) && other.find(name)) suggestion = other.key_prefix("NAME") + name;
  return Error(
      Fault::bad_data,
      {.where = where_text(place, full_name), .what = "unknown key", .remedy = "did you mean " + suggestion + "?"});
}

// In a file an unknown table is reported by the first key in it, which tells more of what was meant.
Error unknown_key_error(const SceneValue& value, const SceneSection& section, const std::string& thing,
                        std::string name) {
  const SceneValue* innermost = &value;
  while (const auto* table = innermost->as<SceneValue::Table>()) {
    if (table->empty()) break;
    name += "." + table->front().name;
    innermost = &table->front().value;
  }
  return unknown_key_error(innermost->place, section, thing, name);
}

Error unknown_section_error(const SourcePlace& place, const std::string& full_name) {
  const std::string name = full_name.substr(0, full_name.find('.'));
  std::vector<std::string> known;
  for (const SceneSection& section : scene_sections())
    if (section.name.empty())
      for (const SceneKey& key : section.keys) known.push_back(key.name);
    else if (section.within.empty())
      known.push_back(section.name);
  std::string suggestion = nearest_word(name, known);
  const SceneSection* section = find_section(suggestion);
  if (section) suggestion = section->named ? "[" + suggestion + ".NAME]" : "[" + suggestion + "]";
  for (const SceneSection& other : scene_sections())
    if (other.find(name)) suggestion = other.key_prefix("NAME") + name;
  return Error(
      Fault::bad_data,
      {.where = where_text(place, full_name), .what = "unknown key", .remedy = "did you mean " + suggestion + "?"});
}

Error table_key_error(const SourcePlace& place, const SceneSection& section, const std::string& full_name,
                      const std::string& name) {
  std::vector<std::string> inside;
  for (const SceneKey& key : section.keys)
    if (key.name.compare(0, name.size() + 1, name + ".") == 0) inside.push_back(key.name.substr(name.size() + 1));
  return Error(Fault::bad_data, {.where = where_text(place, full_name),
                                 .what = "is a table of keys, not a value",
                                 .remedy = "its keys are " + list_text(inside)});
}

// Puts a table's entries where the table of keys wants them; `start` is the key so far, with its dot.
void sort_entries(const SceneSection& section, const std::string& thing, const std::string& start,
                  const SceneValue::Table& table, DocumentThing& into) {
  for (const auto& [part, value] : table) {
    const std::string name = start + part;
    const std::string full_name = section.key_prefix(thing) + name;
    if (section.find(name)) {
      SceneValue& entry = into.values[name] = value;
      set_key(entry, full_name);
    } else if (is_prefix(section, name)) {
      const auto* inner = value.as<SceneValue::Table>();
      if (!inner) throw table_key_error(value.place, section, full_name, name);
      sort_entries(section, thing, name + ".", *inner, into);
    } else {
      throw unknown_key_error(value, section, thing, name);
    }
  }
}

const SceneValue::Table& table_of(const SceneValue& value, const std::string& key, const std::string& header) {
  if (const auto* table = value.as<SceneValue::Table>()) return *table;
  SceneValue named = value;
  named.key = key;
  throw value_error(named, "must be a table, but is " + type_text(value), "write it as " + header);
}

void check_name(const SourcePlace& place, const std::string& section, const std::string& name) {
  if (is_name(name)) return;
  throw Error(Fault::bad_data, {.where = where_text(place, section),
                                .what = "is no name for a " + section,
                                .value = toml_string(name),
                                .remedy = "use letters, digits, - and _"});
}

// Sorts the tables of things within a thing, each kind into a section of its own; gives back the thing's other entries.
SceneValue::Table without_inner(const SceneSection& section, const std::string& thing, const SceneValue::Table& table,
                                SceneDocument& document) {
  SceneValue::Table others;
  for (const auto& [part, value] : table) {
    const SceneSection* inner = find_inner_section(section, part);
    if (!inner) {
      others.push_back({part, value});
      continue;
    }
    const std::string start = section.header(thing) + "." + part;
    for (const auto& [name, entry] : table_of(value, start, "[" + start + ".PIN]")) {
      check_name(entry.place, part, name);
      const std::string full = thing + "." + name;
      DocumentThing& into = document[part][full];
      into.place = entry.place;
      sort_entries(*inner, full, "", table_of(entry, inner->header(full), "[" + inner->header(full) + "]"), into);
    }
  }
  return others;
}

void sort_section(const SceneSection& section, const SceneValue& value, SceneDocument& document) {
  auto& things = document[section.name];
  const std::string header = section.named ? "[" + section.name + ".NAME]" : "[" + section.name + "]";
  const SceneValue::Table& table = table_of(value, section.name, header);
  if (!section.named) {
    DocumentThing& into = things[""];
    into.place = value.place;
    sort_entries(section, "", "", table, into);
    return;
  }
  for (const auto& [name, thing] : table) {
    const std::string key = section.name + "." + name;
    if (!thing.as<SceneValue::Table>() && section.find(name)) {
      SceneValue named = thing;
      named.key = key;
      throw value_error(named, "stands outside of a named table",
                        "begin it with " + header + ", NAME being a name of your choice");
    }
    check_name(thing.place, section.name, name);
    DocumentThing& into = things[name];
    into.place = thing.place;
    sort_entries(section, name, "", without_inner(section, name, table_of(thing, key, "[" + key + "]"), document),
                 into);
  }
}

std::vector<std::string> split_at_dots(const std::string& key) {
  std::vector<std::string> parts(1);
  for (const char c : key)
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

// Where an override points: a section, a thing in it, and a key of the section.
struct Target {
  const SceneSection* section = nullptr;
  std::string thing, name;
};

Target find_target(const Override& override, const SourcePlace& place) {
  const std::vector<std::string> parts = split_at_dots(override.key);
  Target target;
  target.section = parts.size() == 1 && find_section("")->find(parts[0]) ? find_section("") : find_section(parts[0]);
  if (!target.section || parts[0].empty() || !target.section->within.empty())
    throw unknown_section_error(place, override.key);
  if (parts.size() > 2)
    if (const SceneSection* inner = find_inner_section(*target.section, parts[2])) target.section = inner;
  const bool is_inner = !target.section->within.empty();
  const std::size_t first = is_inner ? 4 : target.section->name.empty() ? 0 : target.section->named ? 2 : 1;
  if (parts.size() <= first) {
    throw Error(Fault::bad_data, {.where = where_text(place, override.key),
                                  .what = "is not a key but a table of keys",
                                  .remedy = "name a key in it, such as " +
                                            target.section->key_prefix(parts.size() > 1 ? parts[1] : "NAME") +
                                            target.section->keys.front().name});
  }
  if (target.section->named) target.thing = is_inner ? parts[1] + "." + parts[3] : parts[1];
  for (std::size_t i = first; i < parts.size(); ++i) target.name += (i > first ? "." : "") + parts[i];
  return target;
}

// Makes sure that the thing is there: keys that define a thing may add one, unless its name looks like a typing error.
void find_or_add_thing(SceneDocument& document, const Target& target, const SceneKey& key, const SourcePlace& place) {
  if (!target.section->named) return;
  auto& things = document[target.section->name];
  if (things.count(target.thing)) return;
  std::vector<std::string> names;
  for (const auto& [name, thing] : things) names.push_back(name);
  const std::string nearest = nearest_word(target.thing, names);
  if (key.defines && (names.empty() || edit_distance(target.thing, nearest) > 2)) {
    check_name(place, target.section->name, target.thing);
    things[target.thing].place = place;
    return;
  }
  throw Error(Fault::bad_data,
              {.where = where_text(place, target.section->key_prefix(target.thing) + target.name),
               .what = "the scene has no " + target.section->name + " of this name",
               .value = target.thing,
               .remedy = names.empty() ? "add it to the scene file"
                                       : "did you mean " + nearest + "? There is " + list_text(names)});
}

void drop(DocumentThing& thing, const std::string& name, bool from_overrides_too) {
  const auto found = thing.values.find(name);
  if (found != thing.values.end() && (from_overrides_too || !found->second.place.is_override))
    thing.values.erase(found);
}

void apply_override(SceneDocument& document, const Override& override, const Target& target, const SceneKey& key,
                    const SourcePlace& place) {
  DocumentThing& thing = document[target.section->name][target.thing];
  for (const SceneKey& other : target.section->keys)
    if (!key.group.empty() && other.group == key.group && other.name != key.name) drop(thing, other.name, true);
  for (const std::string& name : key.resets) drop(thing, name, false);
  if (!key.turns_on.empty()) {
    const auto kind = thing.values.find(key.turns_on);
    const auto* word = kind != thing.values.end() ? kind->second.as<std::string>() : nullptr;
    if (word && *word == "none") drop(thing, key.turns_on, false);
  }
  SceneValue& value = thing.values[key.name] = parse_override_value(override.value, place);
  set_key(value, override.key);
}

}  // namespace

SceneDocument sort_into_keys(const SceneValue& root) {
  SceneDocument document;
  for (const SceneSection& section : scene_sections()) {
    document[section.name];
    if (!section.named) document[section.name][""].place = root.place;
  }
  for (const auto& [name, value] : *root.as<SceneValue::Table>()) {
    if (find_section("")->find(name)) {
      SceneValue& entry = document[""][""].values[name] = value;
      set_key(entry, name);
    } else if (const SceneSection* section = name.empty() ? nullptr : find_section(name);
               section && section->within.empty()) {
      sort_section(*section, value, document);
    } else {
      throw unknown_section_error(value.place, name);
    }
  }
  return document;
}

void apply_overrides(SceneDocument& document, const std::vector<Override>& overrides,
                     const std::filesystem::path& folder) {
  const SourcePlace place{.file = "--set", .folder = folder, .is_override = true};
  std::vector<std::pair<Target, const SceneKey*>> targets;
  for (const Override& override : overrides) {
    const Target target = find_target(override, place);
    const SceneKey* key = target.section->find(target.name);
    if (!key && is_prefix(*target.section, target.name))
      throw table_key_error(place, *target.section, override.key, target.name);
    if (!key) throw unknown_key_error(place, *target.section, target.thing, target.name);
    targets.emplace_back(target, key);
  }
  // keys that add a thing come first, whatever the order on the command line
  for (const bool defines : {true, false})
    for (const auto& [target, key] : targets)
      if (key->defines == defines) find_or_add_thing(document, target, *key, place);
  for (std::size_t i = 0; i < overrides.size(); ++i)
    apply_override(document, overrides[i], targets[i].first, *targets[i].second, place);
}

void check_groups(const SceneDocument& document) {
  for (const SceneSection& section : scene_sections())
    for (const auto& [name, thing] : document.at(section.name)) {
      std::map<std::string, const SceneValue*> given;
      for (const SceneKey& key : section.keys) {
        const auto value = thing.values.find(key.name);
        if (key.required && value == thing.values.end())
          throw Error(Fault::bad_data, {.where = where_text(thing.place, section.key_prefix(name) + key.name),
                                        .what = "is missing",
                                        .remedy = "give it: " + key.meaning + ", " + key.type});
        if (key.group.empty() || value == thing.values.end()) continue;
        const auto [first, is_first] = given.try_emplace(key.group, &value->second);
        if (!is_first)
          throw value_error(value->second,
                            "only one of " + key.group + " may be given, and " + first->second->key + " is, too",
                            "remove one of them");
      }
    }
}

std::string list_text(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

}  // namespace umax
