// The character of figures 1 and 6: the paper's armadillo when its file is given, else the program's own figure.
#pragma once

#include <string>
#include <vector>

#include "tools/reproduce/limb_height.h"
#include "tools/reproduce/workbench.h"

namespace umax {

struct Character {
  std::string scene;  // built-in
  std::string body;   // key of the body in it: "body.armadillo"
  std::string label;
  std::vector<std::string> settings;  // as in the paper: 2 m tall, 365 hexes, 500 kg/m³, friction 0.5, from 2 m
  LimbBox right_leg;
};

Character character_of(const Workbench& bench);

/// What is said where the armadillo is not given.
std::string stand_in_note();

}  // namespace umax
