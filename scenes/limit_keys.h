// Scene keys of limits: on the whole energy of a body's hexes and on its parts.
#pragma once

#include "scenes/map_keys.h"

namespace umax {

// What one limit is called, and where it stands in a body.
struct LimitPlace {
  EnergyPart part = EnergyPart::whole;
  std::string of = {};  // what it bounds: "elastic energy"

  EnergyLimitOptions& in(BodyDescription& body) const { return limit_on(body.limit, body.part_limits, part); }
  const EnergyLimitOptions& in(const BodyDescription& body) const {
    return limit_on(body.limit, body.part_limits, part);
  }
  std::string key(const std::string& name) const { return std::string(limit_name(part)) + "." + name; }
  // parts that are not limited leave no more than their kind in a resolved scene
  bool is_told(const BodyDescription& body) const {
    return part == EnergyPart::whole || in(body).kind != LimitKind::none;
  }
};

// One of limit.energy, .density, .stretch. A limit that is given is a hard one unless limit.kind says otherwise.
template <class Kind, class Keys>
void add_limit_key(Keys& keys, const LimitPlace& place, const std::string& name, LimitUnit unit, const Kind& kind,
                   const std::string& meaning) {
  const TrackKind<Kind> track{kind};
  const auto set = [place, track, unit](const SceneValue& value, BodyDescription& body) {
    EnergyLimitOptions& limit = place.in(body);
    limit.kind = LimitKind::hard;
    limit.unit = unit;
    limit.value = track.read(value);
  };
  const auto get = [place, track, unit](const BodyDescription& body) -> std::optional<std::string> {
    const EnergyLimitOptions& limit = place.in(body);
    return limit.unit == unit && place.is_told(body) ? std::optional(track.write(limit.value)) : std::nullopt;
  };
  const bool is_default = place.part == EnergyPart::whole && unit == EnergyLimitOptions().unit;
  keys.add_custom(place.key(name), track.type(), meaning,
                  {.unset = is_default ? "" : "none",
                   .group = place.key("energy") + ", " + place.key("density") + " or " + place.key("stretch"),
                   .turns_on = place.key("kind")},
                  set, get);
}

template <class Keys>
void add_measure_key(Keys& keys, const LimitPlace& place) {
  const ChoiceKind<LimitMeasure> kind{{{"mean", LimitMeasure::mean}, {"peak", LimitMeasure::peak}}};
  keys.add_custom(
      place.key("measure"), kind.type(),
      "mean: over the hex; peak: the largest density at its 8 quadrature points, so that bending does not hide",
      {.unset = "\"mean\""},
      [place, kind](const SceneValue& value, BodyDescription& body) { place.in(body).measure = kind.read(value); },
      [place, kind](const BodyDescription& body) -> std::optional<std::string> {
        return place.is_told(body) ? std::optional(kind.write(place.in(body).measure)) : std::nullopt;
      });
}

template <class Keys>
void add_limit_keys(Keys& keys, const LimitPlace& place) {
  add_limit_key(keys, place, "energy", LimitUnit::energy, NumberKind{units::energy, positive},
                "most " + place.of + " of each hex");
  add_limit_key(keys, place, "density", LimitUnit::density, NumberKind{units::energy_density, positive},
                "most " + place.of + " per volume of full hex: nearly independent of the cage");
  add_limit_key(keys, place, "stretch", LimitUnit::stretch, StretchKind(),
                "the " + place.of + " of this uniaxial stretch is the limit; 0.2 is 20 %");
  keys.add(place.key("kind"),
           ChoiceKind<LimitKind>{{{"none", LimitKind::none}, {"hard", LimitKind::hard}, {"soft", LimitKind::soft}}},
           [place](auto& body) -> auto& { return place.in(body).kind; },
           place.part == EnergyPart::whole
               ? "none: linear elastic; hard: never exceeded; soft: a stiffening barrier before the limit"
               : "as limit.kind, of this limit alone",
           {.unset = "\"none\"; \"hard\" where a limit is given"});
  add_measure_key(keys, place);
}

/// All keys below "limit.".
template <class Keys>
void add_all_limit_keys(Keys& keys) {
  add_limit_keys(keys, {EnergyPart::whole, "elastic energy"});
  add_limit_keys(keys, {EnergyPart::volumetric, "energy of volume change, ½ K tr²ε,"});
  add_limit_keys(keys, {EnergyPart::deviatoric, "energy of shape change, µ dev ε : dev ε,"});
  add_limit_keys(keys, {EnergyPart::fibre, "energy of stretch along the fibre, ½ Y (f·εf)²,"});
  const VectorKind direction{units::ratio, {}};
  keys.add_custom(
      "limit.fibre.direction", direction.type(),
      "of the fibre, any length, in the rest shape as it is placed (world axes at time 0); it turns with the hexes", {},
      [direction](const SceneValue& value, BodyDescription& body) {
        const Vector3d read = direction.read(value);
        if (!(read.norm() > 0)) throw value_error(value, "is no direction", "give one such as [0, 1, 0]");
        body.part_limits.fibre_direction = read;
      },
      [direction](const BodyDescription& body) {
        return std::optional(direction.write(body.part_limits.fibre_direction));
      });
  add_direction_map_keys(keys, "limit.fibre.direction_map", UMAX_FIELD(fibre_map));
  add_factor_map_keys(keys, "limit.map", UMAX_FIELD(limit_map), "the energy that the limit allows");
}

}  // namespace umax
