// glTF files that name no scene to show: the same file with one that shows everything.
#pragma once

#include <optional>
#include <string>

namespace umax {

/// The bytes of a .gltf or .glb file with a default scene: the first of its scenes, else one of all nodes that hang on
/// no other, else one of all meshes. Nothing where it has a scene already, or cannot be understood.
std::optional<std::string> with_default_scene(const std::string& bytes);

}  // namespace umax
