// What umax aim is asked for: how wants and ranges are read, and each measure against a closed form.
#include <cmath>

#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tools/aim/key_range.h"
#include "tools/aim/want_reading.h"

using namespace umax;
using umax::test::contains;
using umax::test::failure_of;

namespace {

/// A block of 0.4 x 0.8 x 0.2 m whose states the tests make themselves; 61 frames are a second.
Scene block_scene() {
  return parse_scene({.text = R"([clip]
frames = 61
[body.block]
shape = "box"
size = [0.4, 0.8, 0.2]
position = [0.1, 1, 0]
cage.cells = [2, 4, 1]
material.young = "20 kPa"
material.poisson = 0
limit.kind = "none"
[probe.top]
body = "block"
point = [0.1, 1.4, 0]
)"});
}

struct MadeBlock {
  Scene scene = block_scene();
  Simulation simulation = set_up(scene);

  Want want(const std::string& text) const { return parse_want(text, scene); }

  /// The block, stretched about its middle and moved, in a state of its own.
  State state(const Vector3d& stretch, const Vector3d& move = Vector3d::Zero()) const {
    State state = rest_state(simulation.model);
    const Vector3d middle(0.1, 1, 0);
    for (Eigen::Index i = 0; i < state.positions.rows(); ++i) {
      const Vector3d offset = state.positions.row(i).transpose() - middle;
      state.positions.row(i) = (middle + stretch.cwiseProduct(offset) + move).transpose();
    }
    return state;
  }

  Reading read(const std::string& text, const StateSource& states) const {
    return read_want(want(text), simulation, states);
  }
  double value(const std::string& text, const Vector3d& stretch, const Vector3d& move = Vector3d::Zero()) const {
    return read(text, [&](int) { return state(stretch, move); }).value;
  }
};

test::Failure refused(const std::string& text) {
  return failure_of([&] { parse_want(text, load_scene("beam")); });
}

KeyRange range_of(const std::string& text, const std::string& scene = "figure") {
  return parse_range(text, scene, {});
}

test::Failure refused_range(const std::string& text) {
  return failure_of([&] { range_of(text); });
}

}  // namespace

TEST_CASE("a want names a measure, what it is of, when, and a value", "[aim]") {
  const MadeBlock block;
  const Want height = block.want("height(block) at 0.6 s = 85 %");
  CHECK(height.measure == MeasureKind::height);
  CHECK(height.moment == WantMoment::instant);
  CHECK(height.from == 0.6);
  CHECK(height.value == Approx(0.85));
  CHECK(height.is_share);
  CHECK(height.name == "height(block) at 0.6 s");
  const Want width = block.want("max  width( block ) from 200 ms to 1 s=12cm");
  CHECK(width.moment == WantMoment::most);
  CHECK(width.from == Approx(0.2));
  CHECK(width.to == 1);
  CHECK(width.value == Approx(0.12));
  CHECK_FALSE(width.is_share);
  CHECK(block.want("length(block, z) at frame 31 = 0.3").from == Approx(0.5));
  CHECK(block.want("length(block, z) at end = 0.3").from == Approx(1));
  CHECK(block.want("min tip(top, x) = -30 cm").value == Approx(-0.3));
  CHECK(block.want("min tip(top, x) = -30 cm").to == Approx(1));
  CHECK(block.want("rest(block) = 500 ms").value == Approx(0.5));
  CHECK(block.want("bounce(block) = 40 %").is_share);
  CHECK_FALSE(block.want("max stretch(block) = 12 %").is_share);
  CHECK(block.want("max stretch(block) = 12 %").value == Approx(0.12));
}

TEST_CASE("a want that is none is wrong usage: it says what is wrong, where, and how to mend it", "[aim]") {
  for (const char* text : {"",
                           "=",
                           "height",
                           "height = 1",
                           "height(beam) at 0.1 s",
                           "height(beam) = 85 %",
                           "height() at 1 s = 1",
                           "height(beam, x) at 1 s = 1",
                           "length(beam) at 1 s = 1",
                           "length(beam, w) at 1 s = 1",
                           "tip(tip) at 1 s = 1",
                           "min height(beam) at 1 s = 1 m",
                           "height(beam) from 0 s to 1 s = 1 m",
                           "min height(beam) from 1 s to 0 s = 1 m",
                           "min height(beam) from 1 s = 1 m",
                           "height(beam) at 1 kg = 1 m",
                           "height(beam) at -1 s = 1 m",
                           "height(beam) at 1 s = 1 kg",
                           "height(beam) at 1 s = 0",
                           "height(beam) at 1 s = -3 cm",
                           "tip(tip, y) at 1 s = 50 %",
                           "rest(beam) at 1 s = 1 s",
                           "min rest(beam) = 1 s",
                           "rest(beam) = 85 %",
                           "max stretch(beam) = 15",
                           "height(beam) soon = 85 %",
                           "height(beam) at 9 s = 85 %",
                           "min height(beam) from 0.001 s to 0.002 s = 85 %"}) {
    CAPTURE(text);
    const test::Failure failure = refused(text);
    CHECK(failure.code == 2);
    CHECK(failure.where == std::string("--want ") + text);
    CHECK(!failure.what.empty());
    CHECK(!failure.remedy.empty());
  }
  CHECK(contains(refused("hight(beam) at 1 s = 85 %").message, "did you mean height?"));
  CHECK(contains(refused("height(beem) at 1 s = 85 %").message, "got beem; did you mean beam?"));
  CHECK(contains(refused("tip(top, y) at 1 s = 1").message, "did you mean tip?"));
  CHECK(contains(refused("height(beam) at 9 s = 85 %").remedy, "--set clip.frames=901"));
}

TEST_CASE("only as many frames are simulated as a want needs", "[aim]") {
  const MadeBlock block;
  const auto last = [&](const char* text) { return last_frame_of(block.want(text), block.scene.clip); };
  CHECK(last("height(block) at 0.5 s = 1") == 31);
  CHECK(last("height(block) at 0.501 s = 1") == 32);
  CHECK(last("height(block) at 0 s = 1") == 1);
  CHECK(last("max height(block) from 0.1 s to 0.25 s = 1") == 16);
  CHECK(last("max height(block) = 1") == 61);
  CHECK(last("bounce(block) = 10 %") == 61);
}

TEST_CASE("height, width and length are those of the box around the surface, a percentage is of the placed one",
          "[aim]") {
  const MadeBlock block;
  const Vector3d stretch(1.5, 0.6, 0.9), move(3, -2, 1);
  CHECK(block.value("height(block) at 0.1 s = 85 %", stretch, move) == Approx(0.6));
  CHECK(block.value("height(block) at 0.1 s = 10 cm", stretch, move) == Approx(0.48));
  CHECK(block.value("width(block) at 0.1 s = 85 %", stretch, move) == Approx(1.5));
  CHECK(block.value("width(block) at 0.1 s = 1 m", stretch, move) == Approx(0.6));
  CHECK(block.value("length(block, z) at 0.1 s = 1 m", stretch, move) == Approx(0.18));
  CHECK(block.value("length(block, z) at 0.1 s = 50 %", stretch, move) == Approx(0.9));
  CHECK(block.value("squash(block) at 0.1 s = 50 %", stretch, move) == Approx(0.6 / std::sqrt(1.5 * 0.9)));
  CHECK(block.value("squash(block) at 0.1 s = 50 %", Vector3d(1, 1, 1), move) == Approx(1));
}

TEST_CASE("a tip is a probe's coordinate, and what is left counts by how far it has to go", "[aim]") {
  const MadeBlock block;
  const Vector3d stretch(1.5, 0.5, 1), move(3, -2, 1);
  CHECK(block.value("tip(top, x) at 0.1 s = 1 m", stretch, move) == Approx(3.1));
  CHECK(block.value("tip(top, y) at 0.1 s = 1 m", stretch, move) == Approx(1 + 0.5 * 0.4 - 2));
  const Reading reading = block.read("tip(top, y) at 0.1 s = 0.9 m", [&](int) { return block.state({1, 1, 1}); });
  CHECK(reading.scale == Approx(0.5));
  CHECK(miss_of(block.want("tip(top, y) at 0.1 s = 0.9 m"), reading) == Approx(1));
  // where it has nowhere to go: a tenth of the body
  CHECK(block.read("tip(top, z) at 0.1 s = 0 m", [&](int) { return block.state({1, 1, 1}); }).scale == Approx(0.08));
}

TEST_CASE("the largest stretch is that of a bar drawn out along an axis", "[aim]") {
  const MadeBlock block;  // its Poisson's ratio is 0: U = Y e^2 V / 2
  CHECK(block.value("stretch(block) at 0.1 s = 10 %", Vector3d(1, 1.13, 1)) == Approx(0.13).epsilon(1e-6));
  CHECK(block.value("max stretch(block) = 10 %", Vector3d(0.9, 1, 1)) == Approx(0.1).epsilon(1e-6));
}

TEST_CASE("between frames a measure lies on a straight line, over a span it is the least or the most", "[aim]") {
  const MadeBlock block;
  const StateSource states = [&](int frame) { return block.state(Vector3d(1, 1 + 0.01 * (frame - 31), 1)); };
  CHECK(block.read("height(block) at 0.5 s = 1", states).value == Approx(0.8));
  CHECK(block.read("height(block) at 0.505 s = 100 %", states).value == Approx(1 + 0.01 * 0.3));
  const StateSource bump = [&](int frame) { return block.state(Vector3d(1, 1 - 0.02 * std::abs(frame - 31), 1)); };
  const Reading most = block.read("max height(block) from 0.2 s to 0.9 s = 100 %", bump);
  CHECK(most.value == Approx(1));
  CHECK(most.frame == 31);
  const Reading least = block.read("min height(block) from 0.2 s to 0.9 s = 100 %", bump);
  CHECK(least.value == Approx(1 - 0.02 * 24));
  CHECK(least.frame == 55);
}

TEST_CASE("a body is at rest when its speed, which dies away exponentially, falls below 1 % of its size a second",
          "[aim]") {
  const MadeBlock block;
  const double start = 2, rate = 9;  // [m/s], [1/s]
  const StateSource states = [&](int frame) {
    State state = block.state({1, 1, 1});
    const double time = (frame - 1) / 60.0;
    state.velocities.rowwise() = Eigen::RowVector3d(start * std::exp(-rate * time), 0, 0);
    return state;
  };
  CHECK(block.read("rest(block) = 0.5 s", states).value == Approx(std::log(start / 0.008) / rate).epsilon(1e-9));
  const Reading never = block.read("rest(block) = 0.5 s", [&](int) {
    State state = block.state({1, 1, 1});
    state.velocities.setConstant(0.1);
    return state;
  });
  CHECK(std::isinf(never.value));
  CHECK(miss_of(block.want("rest(block) = 0.5 s"), never) == 10);
}

TEST_CASE("a bounce is how far the lowest point rises again after the first impact, as a share of its fall", "[aim]") {
  const MadeBlock block;
  // lowest point at 0.6 m: falls 0.5 m, comes down at frame 21, rises 0.18 m by frame 31
  const auto height = [](int frame) {
    const double fall = (frame - 1) / 20.0, rise = (frame - 31) / 10.0;
    return frame <= 21 ? 0.5 * (1 - fall * fall) : 0.18 * (1 - rise * rise);
  };
  const StateSource states = [&](int frame) { return block.state({1, 1, 1}, {0, height(frame) - 0.5, 0}); };
  const StateSource first = [&](int frame) { return states(std::min(frame, 41)); };
  CHECK(block.read("bounce(block) = 20 cm", first).value == Approx(0.18));
  CHECK(block.read("bounce(block) = 30 %", first).value == Approx(0.18 / 0.5));
  CHECK(block.read("bounce(block) = 30 %", first).frame == 31);
  const auto falls = [&](int frame) { return block.state({1, 1, 1}, {0, -0.01 * frame, 0}); };
  const test::Failure failure = failure_of([&] { block.read("bounce(block) = 30 %", falls); });
  CHECK(failure.code == 65);
  CHECK(contains(failure.remedy, "clip.frames="));
}

TEST_CASE("a range is read in the user's unit and walked by equal factors where its ends are far apart", "[aim]") {
  const KeyRange stretch = range_of("body.figure.limit.stretch = 2% .. 60 %");
  CHECK(stretch.low == Approx(0.02));
  CHECK(stretch.high == Approx(0.6));
  CHECK(stretch.logarithmic);
  CHECK(stretch.value_at(0.5) == Approx(std::sqrt(0.02 * 0.6)));
  CHECK(value_text(stretch, 0.5) == "10.954 %");
  CHECK(stretch.place_of(stretch.value_at(0.3)) == Approx(0.3));
  REQUIRE(stretch.own);
  CHECK(stretch.value_at(*stretch.own) == Approx(0.2));
  const KeyRange young = range_of("body.figure.material.young=80..120 kPa");
  CHECK(young.low == 80000);
  CHECK_FALSE(young.logarithmic);
  CHECK(value_text(young, 0.5) == "100 kPa");
  CHECK(value_text(range_of("body.figure.material.young=500 kPa..2 MPa"), 0) == "0.5 MPa");
  CHECK(value_text(range_of("body.figure.material.poisson=0.4..0.1"), 0) == "0.1");
  CHECK_FALSE(range_of("body.figure.limit.stretch=30%..60%").own);
  // a limit that is given as an energy has no stretch of its own
  CHECK_FALSE(range_of("body.beam.limit.stretch=2%..60%", "beam").own);
}

TEST_CASE("a range that is none is refused with the key that was meant", "[aim]") {
  for (const char* text : {"", "body.figure.limit.stretch", "body.figure.limit.stretch=5%", "=1..2",
                           "body.figure.limit.stretch=a..b", "body.figure.limit.stretch=5%..5 %",
                           "body.figure.limit.stretch=..5%", "body.figure.position=1..2", "render.engine=1..2"}) {
    CAPTURE(text);
    const test::Failure failure = refused_range(text);
    CHECK((failure.code == 2 || failure.code == 65));
    CHECK(contains(failure.where, "--vary"));
    CHECK(!failure.remedy.empty());
  }
  CHECK(contains(refused_range("body.figure.limit.strech=2%..60%").message, "did you mean body.figure.limit.stretch?"));
  CHECK(contains(refused_range("body.figure.cage.cells=100..400").where, "--vary body.figure.cage.cells"));
  CHECK(refused_range("body.figure.material.young=2 kg..3 kg").code == 65);
}
