#include "core/model/deformation.h"

#include <algorithm>

namespace umax {
namespace {

constexpr std::size_t most_instants = 4;

}  // namespace

Deformation::Deformation(MeshMotion motion, TriangleShape at_rest)
    : motion_(std::move(motion)), at_rest_(std::move(at_rest)) {}

std::shared_ptr<const ObstacleShape> Deformation::shape_at(double time) const {
  const double at = time_within(motion_, time);
  const std::lock_guard lock(mutex_);
  const auto known =
      std::find_if(latest_.begin(), latest_.end(), [&](const auto& instant) { return instant.first == at; });
  if (known != latest_.end()) {
    std::rotate(known, known + 1, latest_.end());
    return latest_.back().second;
  }
  TriangleShape shape = at_rest_;
  shape.surface = std::make_shared<const RestSurface>(moved_surface(*at_rest_.surface, positions_at(motion_, at)));
  if (latest_.size() == most_instants) latest_.erase(latest_.begin());
  latest_.emplace_back(at, std::make_shared<const ObstacleShape>(std::move(shape)));
  return latest_.back().second;
}

}  // namespace umax
