// From a variant to umax aim: the command that looks for a value around it.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene_document.h"
#include "tools/trials/variants.h"

namespace umax {

/// "umax aim SCENE --set … --vary KEY=A..B": the first varied key whose values are quantities goes from the value before
/// the variant's to the one behind it, in the order of --vary; all others are set. Empty where there is no such key.
std::string aim_command(const std::string& scene, const std::vector<Override>& settings,
                        const std::vector<Variation>& variations, const SceneVariant& variant);

}  // namespace umax
