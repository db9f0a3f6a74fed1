// Pins in scene files: tables within a body's table.
#include "scenes/resolved_scene.h"
#include "tests/scenes/scene_testing.h"

using namespace umax;
using namespace umax::test;

namespace {

const std::string ball = "[body.ball]\nshape = \"sphere\"\n";

}  // namespace

TEST_CASE("pins are tables within a body, are set from the command line and come back from the resolved scene",
          "[pins]") {
  const std::string text = ball + R"([body.ball.pin.top]
box = { min = [-1, 0.5, -1], max = ["1 m", "100 cm", 1] }
follow = { position = { keys = [[0, [0, 0, 0]], [1, [1, 0, 0]]] }, rotation = [0, "90 deg", 0] }
from = "0.5 s"
until = 2
stiffness = "2 kN/m"
[body.ball.pin.side]
sphere = { centre = [1, 0, 0], radius = "20 cm" }
[body.other]
shape = "box"
)";
  const Scene scene = read_text(text, {"body.ball.pin.side.follow.position=[0, 1, 0]", "body.ball.pin.top.until=3 s"});
  REQUIRE(scene.bodies.size() == 2);
  REQUIRE(scene.pins.size() == 2);
  const PinDescription &side = scene.pins[0], &top = scene.pins[1];
  CHECK(side.body == "ball");
  CHECK(side.name == "side");
  CHECK(*side.sphere.centre == Vector3d(1, 0, 0));
  CHECK(*side.sphere.radius == 0.2);
  CHECK(side.position->at(0) == Vector3d(0, 1, 0));
  CHECK_FALSE(side.from);
  CHECK(*top.box.max == Vector3d(1, 1, 1));
  CHECK(top.position->at(0.5) == Vector3d(0.5, 0, 0));
  CHECK(top.rotation_degrees->at(0) == Vector3d(0, 90, 0));
  CHECK(*top.from == 0.5);
  CHECK(*top.until == 3);
  CHECK(*top.stiffness == 2000);
  const std::string resolved = resolved_toml(scene, {});
  CHECK(contains(resolved, "[body.ball.pin.side]"));
  CHECK(resolved_toml(read_text(resolved), {}) == resolved);
}

TEST_CASE("what is wrong with a pin is said with its place", "[pins]") {
  const auto complaint = [](const std::string& pin, const std::vector<std::string>& sets = {}) {
    const Failure failure = failure_of_text(ball + "[body.ball.pin.top]\n" + pin, sets);
    CHECK(failure.code != 0);
    CHECK(!failure.remedy.empty());
    return failure.message;
  };
  const std::string box = "box = { min = [0, 0, 0], max = [1, 1, 1] }\n";
  CHECK(contains(complaint("from = 1\n"), "does not say what it holds"));
  CHECK(contains(complaint(box + "sphere = { centre = [0, 0, 0], radius = 1 }\n"),
                 "only one of box, sphere, map or inside may be given"));
  CHECK(contains(complaint("box = { min = [0, 0, 0], max = [1, -1, 1] }\n"), "min beyond its max"));
  CHECK(contains(complaint("box = { min = [0, 0, 0] }\n"), "must have min and max"));
  CHECK(contains(complaint("sphere = { centre = [0, 0, 0], size = 1 }\n"), "unknown part \"size\""));
  CHECK(contains(complaint(box + "folow.position = [0, 0, 0]\n"), "did you mean body.ball.pin.top.follow"));
  CHECK(contains(complaint(box + "stiffness = \"3 kg\"\n"), "stiffness"));
  CHECK(contains(complaint(box + "from = 2\nuntil = 1\n"), "is no later than from"));
  CHECK(contains(complaint("inside = \"no.obj\"\n"), "no such file"));
  CHECK(contains(complaint(box + "follow.cache = \"no.mdd\"\n"), "no such file or folder"));
  CHECK(contains(complaint(box + "follow.cache_speed = 2\n"), "follow.cache = \"PATH\""));
  CHECK(contains(complaint(box, {"solver.method=paper"}), "knows no pins"));
  CHECK(contains(complaint(box, {"body.ball.pin.other.from=1"}), "has no pin of this name"));
  CHECK(failure_of_text("[pin.top]\n" + box).code == 65);
  CHECK(failure_of_text(ball + "pin = 3\n").code == 65);
  CHECK(failure_of_text(ball + "[body.ball.pin]\ntop = 3\n").code == 65);
}
