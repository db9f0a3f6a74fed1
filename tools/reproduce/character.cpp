#include "tools/reproduce/character.h"

#include "tools/reproduce/experiments.h"

namespace umax {
namespace {

/// The paper's numbers for sections 6.1 and 6.2.
std::vector<std::string> paper_settings(const std::string& body) {
  return {body + ".height=2 m",
          body + ".rotation=[0,0,0]",
          body + ".drop_height=2 m",
          body + ".friction=0.5",
          body + ".contact=obstacles",
          body + ".cage.cells=365",
          body + ".material.young=500 kPa",
          body + ".material.poisson=0.3",
          body + ".material.density=500",
          body + ".material.mass=lattice",
          body + ".material.damping_stiffness=0",
          body + ".limit.energy=100 J",
          "obstacle.ground.friction=0.5",
          "camera.position=[1.4,3.6,6.6]",
          "camera.target=[0,0.95,0.2]",
          "camera.vertical_fov=27"};
}

}  // namespace

Character character_of(const Workbench& bench) {
  Character character;
  if (bench.has_armadillo())
    character = {"armadillo", "body.armadillo", "the armadillo", {}, armadillo_right_leg};
  else
    character = {"figure", "body.figure", "the figure", {}, figure_right_leg};
  character.settings = joined({bench.armadillo_settings(), paper_settings(character.body)});
  return character;
}

std::string stand_in_note() {
  return "the armadillo's mesh is not part of the program; its own character stands in. With the file, give it as "
         "--set "
         "body.armadillo.mesh=armadillo.obj.";
}

}  // namespace umax
