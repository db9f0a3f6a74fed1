// Binds rows of the table of scene keys to the fields of the scene's structs.
#pragma once

#include <type_traits>
#include <utility>

#include "scenes/scene_keys.h"
#include "scenes/value_kinds.h"

// The field of a section's struct that a key stands for, in const and non-const access.
#define UMAX_FIELD(path) ([](auto& thing) -> auto& { return thing.path; })

namespace umax {

template <class Field>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

/// Further properties of a key; all have defaults.
struct KeyTraits {
  std::string unset = {};       // the default in words, where the field holds none
  std::string belongs_to = {};  // when the field exists only sometimes: "shape = \"sphere\""
  std::string group = {};
  std::vector<std::string> resets = {};
  std::string turns_on = {};
  bool defines = false;
  bool required = false;
};

/// Collects the keys of the section whose things are of type Thing; at(scene, index) gives one of them.
template <class Thing, class At>
class SectionBuilder {
 public:
  SectionBuilder(SceneSection& section, At at) : section_(section), at_(at) {}

  /// A key whose reading and writing do not fit add(). set: (const SceneValue&, Thing&); get: const Thing& ->
  /// optional<string>.
  template <class Set, class Get>
  void add_custom(const std::string& name, const std::string& type, const std::string& meaning, const KeyTraits& traits,
                  const Set& set, const Get& get) {
    SceneKey key{.name = name,
                 .type = type,
                 .default_value = traits.unset,
                 .meaning = meaning,
                 .group = traits.group,
                 .resets = traits.resets,
                 .turns_on = traits.turns_on,
                 .defines = traits.defines,
                 .required = traits.required,
                 .read = {},
                 .write = {}};
    if (key.default_value.empty()) key.default_value = get(Thing{}).value_or(traits.required ? "required" : "");
    key.read = [at = at_, set](const SceneValue& value, Scene& scene, std::size_t i) { set(value, at(scene, i)); };
    key.write = [at = at_, get](const Scene& scene, std::size_t i) { return get(at(scene, i)); };
    section_.keys.push_back(std::move(key));
  }

  /// A key bound to a field: field(thing) gives a T& or, null where the key does not apply, a T*; T may be optional.
  template <class Kind, class FieldOf>
  void add(const std::string& name, const Kind& kind, const FieldOf& field, const std::string& meaning,
           const KeyTraits& traits = {}) {
    const auto set = [kind, field, belongs_to = traits.belongs_to](const SceneValue& value, Thing& thing) {
      decltype(auto) target = field(thing);
      if constexpr (std::is_pointer_v<std::remove_reference_t<decltype(target)>>) {
        if (!target) throw value_error(value, "does not fit here", "it belongs to " + belongs_to);
        assign(*target, kind.read(value));
      } else {
        assign(target, kind.read(value));
      }
    };
    const auto get = [kind, field](const Thing& thing) -> std::optional<std::string> {
      decltype(auto) source = field(thing);
      using Source = std::remove_cvref_t<decltype(source)>;
      if constexpr (std::is_pointer_v<Source>) {
        if (!source) return std::nullopt;
        return write(kind, *source);
      } else {
        return write(kind, source);
      }
    };
    add_custom(name, kind.type(), meaning, traits, set, get);
  }

 private:
  template <class Target, class Value>
  static void assign(Target& target, Value value) {
    if constexpr (std::is_same_v<Target, float>)
      target = float(value);
    else
      target = std::move(value);
  }

  // float fields are written as floats: their shortest text is shorter
  template <class Kind, class Source>
  static std::optional<std::string> write(const Kind& kind, const Source& source) {
    if constexpr (IsOptional<Source>::value)
      return source ? write(kind, *source) : std::nullopt;
    else if constexpr (std::is_same_v<Source, float>)
      return number_text(source);
    else
      return kind.write(typename Kind::Value(source));
  }

  SceneSection& section_;
  At at_;
};

/// Builder of a section that there is once; member: the Scene's field.
template <class Thing>
auto plain_section(SceneSection& section, Thing Scene::* member) {
  const auto at = [member](auto& scene, std::size_t) -> auto& { return scene.*member; };
  return SectionBuilder<Thing, decltype(at)>(section, at);
}

/// Builder of a section of named things; member: the Scene's vector of them.
template <class Thing>
auto named_section(SceneSection& section, std::vector<Thing> Scene::* member) {
  section.named = true;
  section.add = [member](Scene& scene, const std::string& name) {
    (scene.*member).emplace_back().name = name;
    return (scene.*member).size() - 1;
  };
  section.names = [member](const Scene& scene) {
    std::vector<std::string> names;
    for (const Thing& thing : scene.*member) names.push_back(thing.name);
    return names;
  };
  const auto at = [member](auto& scene, std::size_t i) -> auto& { return (scene.*member)[i]; };
  return SectionBuilder<Thing, decltype(at)>(section, at);
}

}  // namespace umax
