#include "report/shown_moments.h"

#include <optional>

#include "compare/recorded_run.h"

namespace deform {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

std::optional<std::size_t> farthest(const std::vector<std::vector<Moment>>& variants,
                                    std::size_t last_choice) {
  std::optional<std::size_t> best;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    if (variants[v].empty() || v == last_choice) continue;
    // The same time may be reached with other roundings: then the first one counts.
    const double slack = 1e-9 * variants[v].back().time;
    if (!best || variants[v].back().time > variants[*best].back().time + slack) best = v;
  }
  const bool is_there = last_choice < variants.size() && !variants[last_choice].empty();
  return !best && is_there ? last_choice : best;
}

/// For each moment the number of the same in another variant, or kNone.
std::vector<std::size_t> partners(const std::vector<Moment>& moments,
                                  const std::vector<Moment>& others) {
  std::vector<std::size_t> partners(moments.size(), kNone);
  for (const auto& [i, j] : same_times(moments, others)) partners[i] = j;
  return partners;
}

}  // namespace

ShownMoments shown_moments(const std::vector<std::vector<Moment>>& variants,
                           std::size_t last_choice) {
  ShownMoments shown;
  shown.frames.resize(variants.size());
  const auto base = farthest(variants, last_choice);
  if (!base) return shown;
  const std::vector<Moment>& moments = variants[*base];
  shown.recorded = moments.size();
  std::vector<std::vector<std::size_t>> partner;
  partner.reserve(variants.size());
  for (const auto& others : variants) partner.push_back(partners(moments, others));
  for (std::size_t i = 0; i < moments.size(); ++i) {
    bool is_common = true;
    for (std::size_t v = 0; v < variants.size(); ++v) {
      const bool reached = !variants[v].empty() && moments[i].time < variants[v].back().time;
      if (reached && partner[v][i] == kNone) is_common = false;
    }
    if (!is_common) continue;
    shown.moments.push_back(moments[i]);
    for (std::size_t v = 0; v < variants.size(); ++v) {
      if (partner[v][i] != kNone) shown.frames[v].push_back(partner[v][i]);
    }
  }
  return shown;
}

std::vector<std::size_t> every(std::size_t stride, std::size_t count) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i + 1 < count; i += stride) kept.push_back(i);
  if (count > 0) kept.push_back(count - 1);
  return kept;
}

ShownMoments every(std::size_t stride, const ShownMoments& all) {
  ShownMoments kept;
  kept.recorded = all.recorded;
  kept.frames.resize(all.frames.size());
  for (const std::size_t i : every(stride, all.moments.size())) {
    kept.moments.push_back(all.moments[i]);
    for (std::size_t v = 0; v < all.frames.size(); ++v) {
      if (i < all.frames[v].size()) kept.frames[v].push_back(all.frames[v][i]);
    }
  }
  return kept;
}

}  // namespace deform
