// Ground, lights and sky for bodies that come without a scene, in proportion to their size.
#pragma once

#include <Eigen/Geometry>

#include "scenes/scene.h"

namespace umax {

enum class Staging {
  studio,  // a sweep without a horizon, a soft key from the left, a rim light from behind
  sky,     // outdoors, under the afternoon's sun
  plain,   // even light on white
};

/// Adds a ground at height `floor`, lights and a sky for something of a size [m]: its height, or more where it is wide.
void add_stage(Scene& scene, Staging staging, double size, double floor);

/// Lights and the sky of the studio for a scene that wants some: in proportion to its bodies, whose box at time 0 that is
/// [m]. Grounds without `fade` pass into the studio's horizon.
void light_scene(const Eigen::AlignedBox3d& bodies, Scene& scene);

/// Smooth and a little glossy. A mesh without colours of its own is of clay; the next bodies of several (number 1, 2, …) have
/// tones that go with it, so that they are told apart.
Look studio_look(bool has_own_colors, int number = 0);

}  // namespace umax
