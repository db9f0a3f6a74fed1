// Bodies that are inside each other: how deep, and the way by which they leave.
#pragma once

#include <vector>

#include "core/contact/contact.h"
#include "core/contact/overlap.h"

namespace umax {

/// Bodies that are inside others or themselves, of those that may touch, by a and b.
std::vector<Overlap> find_overlaps(const Model& model, const ContactGeometry& geometry, const Points& positions);

/// Depth [m] of each surface point in another body or a far part of its own; 0: outside. #P
VectorXd overlap_depths(const Model& model, const ContactGeometry& geometry, const Points& positions);

/// Depth [m] of the deepest vertex inside another body or a far part of its own; 0: none is. known: what such searches
/// remember, of which nothing that is found depends; null: nothing.
double max_surface_penetration(const Model& model, const ContactGeometry& geometry, const Points& positions,
                               std::shared_ptr<Clearances> known = nullptr);

/// Is one of the contacts' vertices deep inside a body at the step's start?
bool are_deep(const ContactStep& step, const std::vector<Contact>& contacts);

/// Of bodies that are deep inside each other at the step's start.
DeepStart find_deep_start(const ContactStep& step);

}  // namespace umax
