// Figure 6: the armadillo falls; three materials, four instants.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tools/reproduce/character.h"
#include "tools/reproduce/experiments.h"
#include "tools/reproduce/limb_height.h"
#include "tools/reproduce/run_measures.h"

namespace umax {
namespace {

constexpr int frames_of_armadillo = 251;

std::vector<Variant> materials(const std::string& body) {
  return {{"compliant", "500 kPa", {body + ".limit.kind=none"}},
          {"limited", "500 kPa, U ≤ 100 J", {body + ".limit.energy=100 J"}},
          {"stiff", "5 MPa", {body + ".limit.kind=none", body + ".material.young=5 MPa"}}};
}

constexpr double impact_seconds = 0.3;

/// Frame of the first contact, and the last of the impact that follows.
std::pair<int, int> impact_frames(const Run& run) {
  const std::vector<double>& contacts = run.column("contacts");
  const auto touch = std::find_if(contacts.begin(), contacts.end(), [](double count) { return count > 0; });
  const int first = std::min(int(touch - contacts.begin()) + 2, run.num_frames());
  return {first, std::min(first + int(impact_seconds * run.simulation->scene.clip.fps), run.num_frames())};
}

/// The right leg, frame by frame: what is left of its height, and of its length; the least of both in the impact, and
/// the lowest that the body's highest point is then.
struct LegMotion {
  std::vector<double> time, height, length;                                                     // [s], [m], [m]
  double least_height = 0, least_length = 0, rest_height = 0, rest_length = 0, lowest_top = 0;  // [m]
  int least_frame = 1;                                                                          // of the length
};

LegMotion leg_motion(const Run& run, const LimbBox& box) {
  const Limb leg = select_limb(run.simulation->bodies.front().shape.mesh.positions, box);
  LegMotion motion;
  motion.rest_height = leg.rest_height;
  motion.rest_length = leg.rest_length;
  std::vector<double> top;
  for (int frame = 1; frame <= run.num_frames(); ++frame) {
    const Points surface = surface_points(run, run.state(frame));
    motion.time.push_back(run.time_of(frame));
    motion.height.push_back(limb_height(leg, surface));
    motion.length.push_back(limb_length(leg, surface));
    top.push_back(surface.col(1).maxCoeff());
  }
  const auto [first, last] = impact_frames(run);
  const auto least = std::min_element(motion.length.begin() + first - 1, motion.length.begin() + last);
  motion.least_length = *least;
  motion.least_frame = int(least - motion.length.begin()) + 1;
  motion.least_height = *std::min_element(motion.height.begin() + first - 1, motion.height.begin() + last);
  motion.lowest_top = *std::min_element(top.begin() + first - 1, top.begin() + last);
  return motion;
}

ReportRow row_of(const std::string& label, const Run& run, const LegMotion& leg) {
  return {label,
          {number_cell(leg.least_height), number_cell(100 * (1 - leg.least_height / leg.rest_height)),
           number_cell(leg.least_length), number_cell(100 * (1 - leg.least_length / leg.rest_length)),
           number_cell(leg.lowest_top), number_cell(largest(run.column("limits_active"))),
           number_cell(largest(run.column("contacts"))), number_cell(largest(run.column("max_energy_ratio")), 5),
           number_cell(num_unconverged(run))}};
}

ReportPlot leg_plot(const std::vector<Variant>& labels, const std::vector<LegMotion>& motions) {
  ReportPlot plot{.plot = {.title = "The right leg"},
                  .caption = "Its height (vertical extent) and length (between its ends). Paper's method and energy."};
  plot.plot.x.label = "time [s]";
  PlotPanel height, length;
  height.y.label = "height [m]";
  length.y.label = "length [m]";
  for (std::size_t i = 0; i < labels.size(); ++i) {
    height.series.push_back({labels[i].label, motions[i].time, motions[i].height});
    length.series.push_back({labels[i].label, motions[i].time, motions[i].length});
  }
  plot.plot.panels = {height, length};
  return plot;
}

}  // namespace

ReportSection figure6(Workbench& bench) {
  const Character character = character_of(bench);
  const std::vector<Variant> ways{published_way(), exact_way()}, bodies = materials(character.body);
  ReportTable table{
      .name = "leg",
      .caption = fmt::format(
          "The impact, {} s from the first contact: how short {}'s right leg gets, by its vertical extent and by the "
          "distance between its ends (a leg that tilts loses height, too), and how low the body's highest point.",
          impact_seconds, character.label),
      .columns = {{"least height of the leg", "m"},
                  {"height lost", "%"},
                  {"least length of the leg", "m"},
                  {"length lost", "%"},
                  {"lowest top", "m"},
                  {"most active limits"},
                  {"most contacts"},
                  {"largest U/U_max"},
                  {"steps not converged"}},
      .rows = {}};
  std::vector<Run> published;
  std::vector<LegMotion> motions;
  for (const Variant& way : ways)
    for (const Variant& body : bodies) {
      const Run run = bench.simulate(fmt::format("figure6-{}-{}", body.name, way.name), character.scene,
                                     joined({character.settings,
                                             body.settings,
                                             way.settings,
                                             {"clip.fps=100", fmt::format("clip.frames={}", frames_of_armadillo)}}));
      const LegMotion leg = leg_motion(run, character.right_leg);
      table.rows.push_back(row_of(body.label + "; " + way.label, run, leg));
      if (way.name != ways.front().name) continue;
      published.push_back(run);
      motions.push_back(leg);
    }

  // before the impact, at the compliant leg's worst, and two moments of what follows
  const int worst = motions.front().least_frame;
  std::vector<Tile> tiles;
  for (std::size_t i = 0; i < published.size(); ++i)
    for (const int frame : {worst - 10, worst, worst + 15, worst + 40})
      tiles.push_back(tile_of(published[i], std::clamp(frame, 1, frames_of_armadillo),
                              fmt::format("{}; {:.2f} s", bodies[i].label, published[i].time_of(frame))));
  const auto picture = bench.sheet("figure6", tiles, {.width = 360, .height = 400, .columns = 4, .samples = 128});

  ReportSection section{.name = "figure6", .title = "Figure 6: a falling character of 365 hexes", .blocks = {}};
  section.blocks = {
      ReportText{
          "“Falling armadillo demo, captured at four subsequent time instants. Top: linear-elastic compliant "
          "material; center: energy-limited material; bottom: elastic stiffer material. Our hyperelasticity "
          "simulation method avoids the collapse of the right leg into the ground, while maintaining the dynamics "
          "of upper limbs.”",
          ReportVoice::paper},
      ReportPicture{picture,
                    "Three materials (rows): before the impact, when the compliant body's right leg is shortest, "
                    "and 0.15 s and 0.4 s later. Paper's method and energy."},
      table, leg_plot(bodies, motions),
      ReportText{
          "the pose of the fall is not printed; here the body falls upright, as the mesh stands. The paper gives "
          "no numbers for the leg.",
          ReportVoice::difference}};
  if (!bench.has_armadillo()) section.blocks.push_back(ReportText{stand_in_note(), ReportVoice::difference});
  return section;
}

}  // namespace umax
