// Vertices of hexes that have come into hexes of a body: which ones may touch it, and which one is deepest.
#pragma once

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/contact/clearances.h"
#include "core/contact/contact_detection.h"
#include "core/contact/held_vertex.h"
#include "core/contact/material_point.h"

namespace umax {

/// What a search at some positions goes through. Knows the step's clearances.
struct Search {
  const ContactStep& step;
  const Points& positions;
  Clearances& clearances;
  std::vector<HexBounds> bounds;  // #E
};
Search search_at(const ContactStep& step, const Points& positions);

/// A step in which nothing moves. known: as of begin_contact_step(), of steps at rest.
ContactStep at_rest(const Model& model, const ContactGeometry& geometry, const Points& positions,
                    std::shared_ptr<Clearances> known = nullptr);

/// A hex of the touched body as its vertices' hex sees it.
struct OtherHex {
  int hex = 0;
  Eigen::AlignedBox3d box{};  // of the bounds
  const HexBounds* bounds = nullptr;
  double largest_move = 0;  // [m] of the vertices' hex against this one since its vertices were outside, at rest
};

/// A vertex that may touch.
struct NearVertex {
  int k = 0;                           // which one of the hex
  Vector3d position{0, 0, 0};          // [m]
  int first_other = 0, end_other = 0;  // in Meeting::near_others: hexes that may hold it
  double clear = 0;                    // [m] from touching in the others, at least
};

/// A hex whose vertices may be in hexes of a body, at the positions of a search.
struct Meeting {
  const Model& model;
  const VertexClusters& clusters;
  const Points& apart;  // #N x 3 [m]
  const Model::BodyRange& body;
  int hex = 0;
  const int* vertices = nullptr;  // of the hex, by cluster
  Matrix8x3d nodes;
  Vector3d half_edges;  // longest_half_edges() of these
  std::optional<Leaving> leaving;
  Clearances::OfEncounter& clearance;
  std::vector<OtherHex> others{};
  std::vector<NearVertex> near{};   // the ones that were deepest first
  std::vector<int> near_others{};   // of `others`, by number, vertex by vertex
  std::vector<int> near_cluster{};  // the same of the cluster that is looked at
};

/// Of the search's encounter i. apart: where vertices were last outside.
Meeting meet(const Search& search, const LastApart& apart, std::size_t i);

/// Is the vertex in one of the other hexes, and inside the surface there or perhaps come through it? If not, how far it is
/// from that is remembered.
bool find_held(const Meeting& meeting, const NearVertex& vertex, HeldVertex& held);

/// Remembers how far the vertex, which a hex of the body holds and which meets this there, is from touching; of one that
/// is inside, how deep it is.
void remember(const Meeting& meeting, const NearVertex& vertex, const HeldVertex& held, const Touch& touch);

/// Calls visit(vertex, held) for each vertex for which find_held().
template <class Visit>
void visit_held(const Meeting& meeting, const Visit& visit) {
  HeldVertex held;
  for (const NearVertex& vertex : meeting.near)
    if (find_held(meeting, vertex, held)) visit(meeting.vertices[vertex.k], held);
}

/// The deepest vertex of those with gaps below `below`; point -1: there is none.
struct DeepestVertex {
  int point = -1;
  double gap = 0;  // [m] beyond what is allowed
  HeldVertex held;
  Touch touch;
};

/// deep(held): [m] that is allowed anyway. Vertices of which bounds say that they are not as deep get no closer look.
template <class Deep>
DeepestVertex find_deepest(const Meeting& meeting, double below, const Deep& deep) {
  DeepestVertex deepest;
  deepest.gap = below;
  if (meeting.near.empty()) return deepest;
  const double tie = tied_depth(meeting.model, meeting.hex);
  HeldVertex held;
  for (const NearVertex& vertex : meeting.near) {
    if (!find_held(meeting, vertex, held)) continue;
    const double most = deepest.gap + tie;
    if (!meeting.leaving && least_gap(held) > most) continue;
    const Touch touch = measure(meeting.model, held, meeting.leaving);
    remember(meeting, vertex, held, touch);
    if (touch.gap > most) continue;
    const double gap = touch.gap + deep(held);
    const int point = meeting.vertices[vertex.k];
    const bool is_tied = deepest.point >= 0 && std::abs(gap - deepest.gap) <= tie;
    if (is_tied ? point < deepest.point : gap < deepest.gap) deepest = {point, gap, held, touch};
  }
  return deepest;
}

/// Calls visit(i, encounter i) in parallel.
template <class Visit>
void for_each_encounter(const Search& search, const Visit& visit) {
  const std::vector<Encounter>& encounters = search.clearances.encounters.all;
  parallel_blocks(Eigen::Index(encounters.size()), 1, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) visit(std::size_t(i), encounters[std::size_t(i)]);
  });
}

}  // namespace umax
