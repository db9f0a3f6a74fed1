#include "tools/aim/verdict.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tools/trials/snippet.h"

namespace umax {
namespace {

std::string all_readings(const AimPlan& plan, const AimRun& run) {
  std::vector<std::string> texts;
  for (std::size_t w = 0; w < plan.wants.size(); ++w) texts.push_back(reading_text(plan.wants[w], run.readings[w]));
  return fmt::format("{}", fmt::join(texts, "; "));
}

/// "body.figure.limit.stretch"; "a and b".
std::string keys_text(const AimPlan& plan) {
  std::vector<std::string> names;
  for (const KeyRange& range : plan.keys) names.push_back(range.key);
  return list_text(names);
}

/// "from 70.2 % to 91.4 %", over all runs.
std::string spread_text(const Want& want, std::size_t index, const AimRuns& runs) {
  double least = runs.all().front().readings[index].value, most = least;
  for (const AimRun& run : runs.all()) {
    least = std::min(least, run.readings[index].value);
    most = std::max(most, run.readings[index].value);
  }
  return fmt::format("from {} to {}", value_text(want, least), value_text(want, most));
}

std::string ends_text(const AimPlan& plan, const AimResult& result, const AimRun& best) {
  std::vector<std::string> ends;
  for (const int k : result.keys_at_end) {
    const KeyRange& range = plan.keys[std::size_t(k)];
    ends.push_back(fmt::format("{} at the {} end of its range ({})", range.key, best.place[k] < 0.5 ? "lower" : "upper",
                               value_text(range, best.place[k])));
  }
  return list_text(ends);
}

std::string jump_text(const AimPlan& plan, const AimResult& result, const AimRuns& runs) {
  const AimRun &before = runs.at(result.around_jump[0].place), &behind = runs.at(result.around_jump[1].place);
  const Want& want = plan.wants.front();
  return fmt::format("it jumps from {} to {} between {} and {}", value_text(want, before.readings[0].value),
                     value_text(want, behind.readings[0].value), values_text(plan, before), values_text(plan, behind));
}

/// Whether no run came to rest: a rest is missed by far in all of them.
bool none_rests(const AimPlan& plan, const AimRuns& runs) {
  return plan.wants.front().measure == MeasureKind::rest &&
         std::all_of(runs.all().begin(), runs.all().end(),
                     [](const AimRun& run) { return std::isinf(run.readings.front().value); });
}

std::string reason(const AimPlan& plan, const AimResult& result, const AimRuns& runs, const AimRun& best) {
  const Want& first = plan.wants.front();
  if (none_rests(plan, runs))
    return fmt::format("no run comes to rest within the clip; give it more frames, as by --set clip.frames={}",
                       2 * plan.scene.clip.frames);
  switch (result.end) {
    case AimEnd::flat:
      return fmt::format("{} changes nothing of it in this range; vary another key, or a wider range", keys_text(plan));
    case AimEnd::out_of_range:
      return fmt::format("out of range: with {} it does not get there; it goes {}; vary a wider range, or another key",
                         ends_text(plan, result, best), spread_text(first, 0, runs));
    case AimEnd::not_monotone:
      return fmt::format(
          "not monotone: it turns round before it gets there, and goes {}; vary another "
          "key, or want less",
          spread_text(first, 0, runs));
    case AimEnd::jump:
      return jump_text(plan, result, runs) + "; vary another key, or ask for another moment";
    case AimEnd::conflict:
      return fmt::format("no change of {} leads nearer{}; vary other keys, or want less", keys_text(plan),
                         plan.wants.size() > 1 ? " to all wants at once" : "");
    default:
      return fmt::format("{} runs were not enough; give a narrower range around the nearest", runs.all().size());
  }
}

}  // namespace

std::vector<Override> found_settings(const AimPlan& plan, const AimRun& run) {
  if (!run.is_before()) return settings_of(plan, run);
  std::vector<Override> settings;
  for (const KeyRange& range : plan.keys) settings.push_back({range.key, value_text(range, range.own.value_or(0))});
  return settings;
}

std::string values_text(const AimPlan& plan, const AimRun& run) {
  if (!run.is_before()) return run.label;
  std::vector<std::string> texts;
  for (const KeyRange& range : plan.keys)
    if (range.own) texts.push_back(range.short_key + " " + value_text(range, *range.own));
  return texts.empty() ? run.label : fmt::format("{}", fmt::join(texts, ", "));
}

std::string verdict_text(const AimPlan& plan, const AimResult& result, const AimRuns& runs) {
  const AimRun& best = runs.at(result.tries[result.best].place);
  if (result.end == AimEnd::reached)
    return fmt::format("reached in {} runs{}: {} gives {}{}", runs.all().size(),
                       best.is_before() ? ", the scene has it already" : "", values_text(plan, best),
                       all_readings(plan, best), result.more_than_one ? ". Other values in the range do it too" : "");
  return fmt::format("not reached: {}. The nearest in {} runs: {} gives {}", reason(plan, result, runs, best),
                     runs.all().size(), values_text(plan, best), all_readings(plan, best));
}

}  // namespace umax
