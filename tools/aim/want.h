// What the user wants of a clip, and how it is written: "height(figure) at 0.6 s = 85 %".
//
//   [min | max] MEASURE(BODY) [at TIME | from TIME to TIME] = VALUE
//
//   measure                 what                                                            a percentage is of
//   height(BODY)            of the box around the surface, along y                          its height as it is placed
//   width(BODY)             along x                                                         its width as it is placed
//   length(BODY, AXIS)      along an axis                                                   its length as it is placed
//   tip(PROBE, AXIS)        a coordinate of a probe                                         -
//   squash(BODY)            height over width and depth (geometric mean), 1 as it is placed 1
//   stretch(BODY)           the largest of any hex: sqrt(2 U / (Y V))                       1
//   rest(BODY)              the time from which on it moves less than 1 % of its size a s   -
//   bounce(BODY)            how far its lowest point rises again after the first impact     how far it fell
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace umax {

enum class MeasureKind { height, width, length, tip, squash, stretch, rest, bounce };

enum class WantMoment { instant, least, most, whole };  // whole: of the clip, as rest and bounce are

struct Want {
  std::string text;  // as the user wrote it
  std::string name;  // what is measured: "height(figure) at 0.6 s"
  MeasureKind measure = MeasureKind::height;
  std::size_t object = 0;  // index of the body, or of the probe
  int axis = 1;            // 0: x
  WantMoment moment = WantMoment::instant;
  double from = 0, to = std::numeric_limits<double>::infinity();  // [s] the span; both the same for an instant
  double value = 0;                                               // that is wanted: [m], [s], [-]
  bool is_share = false;  // it is a share [-] of what a percentage is of, although the measure is a length
};

/// Throws Error (usage) that says what is wrong where, and the nearest measure, body or probe.
Want parse_want(const std::string& text, const Scene& scene);

/// A value of what is wanted, for people: "85 %", "0.412 m", "1.35 s".
std::string value_text(const Want& want, double value);

/// The frame, from 1, up to which a clip must be simulated for it.
int last_frame_of(const Want& want, const ClipDescription& clip);

}  // namespace umax
