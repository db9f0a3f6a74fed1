// Scenes and what stands in them: whatever the text is, what is accepted can be written down and means the same again.
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "scenes/presets.h"
#include "scenes/quantity.h"
#include "scenes/resolved_scene.h"
#include "scenes/scene_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace umax::fuzz {
namespace {

constexpr std::array all_units{units::ratio,     units::length,   units::area,         units::time,
                               units::rate,      units::speed,    units::acceleration, units::force,
                               units::stiffness, units::pressure, units::energy,       units::energy_density,
                               units::density,   units::angle,    units::spin,         units::power};

std::filesystem::path folder_of_inputs() {
  return as_file("", "nothing").parent_path();
}

}  // namespace

void read_scene(std::string_view bytes) {
  std::string resolved;
  const auto parse = [](std::string text) {
    return resolved_toml(parse_scene({.text = std::move(text), .folder = folder_of_inputs()}));
  };
  if (!accepts([&] { resolved = parse(std::string(bytes)); })) return;
  try {
    require(parse(resolved) == resolved, "a scene that is written out reads back as itself");
  } catch (const Error& error) {
    break_off(std::string("a scene that is written out is refused: ") + error.what());
  }
}

void read_quantity(std::string_view bytes) {
  for (const Unit& unit : all_units) {
    std::string problem;
    const auto quantity = parse_quantity(bytes, unit, problem);
    require(quantity || !problem.empty(), "what is no quantity is told why");
    if (!quantity) continue;
    require(std::isfinite(quantity->value), "a quantity is finite");
    const auto again = parse_quantity(number_text(quantity->value) + " " + unit.symbol, unit, problem);
    require(again && again->value == quantity->value, "a quantity that is written out is the same again");
  }
  const auto length = parse_length_unit(bytes);
  require(!length || (*length > 0 && std::isfinite(*length)), "a unit of length has one");
}

void read_presets(std::string_view bytes) {
  const auto path = as_file(bytes, "presets.toml");
  accepts([&] {
    for (const Preset& preset : presets(path))
      require(!preset_toml(preset).empty(), "a preset can be written into a scene");
  });
}

}  // namespace umax::fuzz
