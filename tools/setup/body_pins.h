// Pins from a scene: which points of a body they hold, and where these go.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/model/pins.h"
#include "embedding/embedding.h"
#include "tools/setup/body_shape.h"

namespace umax {

/// A body that pins are put into.
struct PinnedBody {
  const std::string& name;
  const PlacedMesh& shape;
  const Lattice& lattice;
  const Embedding& embedding;  // of the shape's mesh, in the lattice
  double young;                // [Pa]
};

/// The scene's pins of the body; null: it has none. Throws Error (bad_data, not_found) that names the pin: it catches no
/// point, its mesh is outside of the cage, its animation is damaged. notes: what each holds, for the user.
std::shared_ptr<const BodyPins> body_pins(const Scene& scene, const PinnedBody& body, std::vector<std::string>& notes,
                                          std::vector<std::string>& warnings);

}  // namespace umax
