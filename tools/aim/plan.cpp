#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "scenes/scene_file.h"
#include "tools/aim/aiming.h"
#include "tools/trials/trial_names.h"

namespace umax {
namespace {

constexpr std::size_t most_wants = 3, most_keys = 3;
constexpr int runs_a_key = 10;

void require_count(const char* option, std::size_t count, std::size_t most, const std::string& example) {
  if (count >= 1 && count <= most) return;
  throw Error(Fault::usage, {.where = "umax aim",
                             .what = std::string("takes one to three ") + option,
                             .value = std::to_string(count),
                             .remedy = "write for example " + example});
}

void require_different(const std::vector<KeyRange>& keys) {
  std::set<std::string> seen;
  for (const KeyRange& range : keys)
    if (!seen.insert(range.key).second)
      throw Error(Fault::usage, {.where = "--vary " + range.key, .what = "is varied twice", .remedy = "leave one out"});
}

}  // namespace

AimPlan plan_aim(const AimRequest& request) {
  require_count("--want", request.wants.size(), most_wants, "--want 'height(figure) at 0.6 s = 85 %'");
  require_count("--vary", request.ranges.size(), most_keys, "--vary body.figure.limit.stretch=2%..60%");
  AimPlan plan{.request = request, .scene = load_scene(request.scene, request.settings), .wants = {}, .keys = {}};
  for (const std::string& text : request.wants) plan.wants.push_back(parse_want(text, plan.scene));
  for (const std::string& text : request.ranges)
    plan.keys.push_back(parse_range(text, request.scene, request.settings));
  require_different(plan.keys);
  std::vector<std::string> names;
  for (const KeyRange& range : plan.keys) names.push_back(range.key);
  for (KeyRange& range : plan.keys) range.short_key = short_key(range.key, names);
  for (const Want& want : plan.wants) plan.last_frame = std::max(plan.last_frame, last_frame_of(want, plan.scene.clip));
  plan.most_runs = runs_a_key * int(plan.keys.size());
  return plan;
}

}  // namespace umax
