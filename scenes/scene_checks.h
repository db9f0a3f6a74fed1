// Checks of a whole scene that no single key can make: whether its things fit together.
#pragma once

#include "scenes/scene_document.h"

namespace umax {

/// Fills in what depends on the rest (a probe's only body), and throws Error for what cannot be simulated or shown.
void complete_and_check(Scene& scene, const SceneDocument& document);

}  // namespace umax
