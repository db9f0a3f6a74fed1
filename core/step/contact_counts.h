// How many contacts a step was solved with, by what touches what.
#pragma once

#include <vector>

#include "core/contact/contact_support.h"
#include "core/step/step.h"

namespace umax {

inline void count_contacts(const Model& model, const std::vector<Contact>& contacts, StepReport& report) {
  report.contacts = int(contacts.size());
  for (const Contact& contact : contacts) {
    const auto [first, second] = bodies_of(model, contact);
    if (second < 0)
      ++report.contacts_obstacles;
    else if (first == second)
      ++report.contacts_within;
    else
      ++report.contacts_between;
  }
}

}  // namespace umax
