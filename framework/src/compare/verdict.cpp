#include "compare/verdict.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace deform {
namespace {

/// A column of the table: a figure by another name.
struct Column {
  std::string figure, name, unit;
  const char* better;  ///< "lower", or null: neither is
};

/// NaN has no place in JSON; nor has infinity.
Json number_json(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// Figures of which less is better, whatever the scene.
bool less_is_better(const std::string& probe) {
  return probe.starts_with("normal_error") || probe.starts_with("mirror_asymmetry") ||
         probe.starts_with("shadow.");
}

std::vector<Column> columns_of(const Comparison& comparison) {
  std::vector<Column> columns{{"distance.max", "largest distance", "m", "lower"},
                              {"rms", "rms at the end", "m", "lower"},
                              {"hausdorff", "Hausdorff at the end", "m", "lower"},
                              {"parts_at", "parts at", "s", nullptr}};
  for (const Figure& probe : probe_columns(comparison))
    columns.push_back(
        {probe.name, probe.name, probe.unit, less_is_better(probe.name) ? "lower" : nullptr});
  return columns;
}

bool measured(const RunComparison& run) {
  return !run.is_reference && run.impossible.empty() && std::isfinite(run.figure("distance.max"));
}

/// "off since 0.2 s" of runs that part.
std::string apart_sentence(const RunComparison& run, const std::string& reference) {
  return fmt::format("{} is {} from {} at the most, first off at {:.3g} s.", run.name,
                     length_text(run.figure("distance.max")), reference, run.parting->time);
}

/// The runs that part, and those that stay, each in one sentence where there are many.
void add_distances(const Comparison& comparison, std::vector<std::string>& sentences) {
  constexpr std::size_t kMostNamed = 6;
  std::vector<const RunComparison*> apart, close;
  for (const RunComparison& run : comparison.runs)
    if (measured(run) && run.outcome.status == "done")
      (run.parting ? apart : close).push_back(&run);
  const auto larger = [](const RunComparison* a, const RunComparison* b) {
    return a->figure("distance.max") > b->figure("distance.max");
  };
  std::ranges::stable_sort(apart, larger);
  std::ranges::stable_sort(close, larger);
  for (std::size_t i = 0; i < std::min(apart.size(), kMostNamed); ++i)
    sentences.push_back(apart_sentence(*apart[i], comparison.reference));
  if (apart.size() > kMostNamed)
    sentences.push_back(fmt::format("So are {} others, by less.", apart.size() - kMostNamed));
  if (close.empty()) return;
  const std::string who = close.size() == 1 ? close.front()->name + " stays"
                          : apart.empty()   ? "All runs stay"
                                            : fmt::format("{} runs stay", close.size());
  sentences.push_back(fmt::format("{} within {} of {} (tolerance {}).", who,
                                  length_text(close.front()->figure("distance.max")),
                                  comparison.reference, length_text(comparison.tolerance)));
}

/// Runs that were measured at some of their times only, as those of another step or a diverged
/// reference are.
void add_gaps(const Comparison& comparison, std::vector<std::string>& sentences) {
  for (const RunComparison& run : comparison.runs)
    if (run.compared > 0 && run.compared + 1 < run.recorded)
      sentences.push_back(
          fmt::format("{} was compared at {} of its {} recorded times: {} has no "
                      "others in common with it.",
                      run.name, run.compared, run.recorded, comparison.reference));
}

/// That the reference did not end as done, first of all: whatever is measured is measured by it.
void add_reference(const Comparison& comparison, std::vector<std::string>& sentences) {
  const auto planned =
      std::ranges::find(comparison.runs, comparison.planned_reference, &RunComparison::name);
  if (planned == comparison.runs.end() || planned->outcome.status == "done") return;
  const bool stands_in = comparison.reference != comparison.planned_reference;
  sentences.push_back(fmt::format(
      "{} was to be the reference, but ended as \"{}\": {}", planned->name, planned->outcome.status,
      stands_in
          ? fmt::format("{}, the first run that is done, is in its place.", comparison.reference)
          : "no run is done, and what is measured against it says little."));
}

/// Runs that a user may take for different ones.
void add_same(const Comparison& comparison, std::vector<std::string>& sentences) {
  constexpr std::size_t kMostNamed = 6;
  std::size_t same = 0;
  for (const RunComparison& run : comparison.runs) {
    if (run.same_as.empty()) continue;
    if (++same <= kMostNamed)
      sentences.push_back(fmt::format("{} is the same scene as {}.", run.name, run.same_as));
  }
  if (same > kMostNamed)
    sentences.push_back(fmt::format("So are {} others of earlier runs.", same - kMostNamed));
}

void add_failures(const Comparison& comparison, std::vector<std::string>& sentences) {
  for (const RunComparison& run : comparison.runs) {
    if (run.outcome.status != "done")
      sentences.push_back(
          fmt::format("{} {}: {}", run.name, run.outcome.status, run.outcome.reason));
    else if (!run.impossible.empty())
      sentences.push_back(fmt::format("{} was not measured: {}.", run.name, run.impossible));
  }
}

}  // namespace

std::string length_text(double metres) {
  struct Prefix {
    double unit;
    const char* name;
  };
  constexpr std::array<Prefix, 5> kPrefixes{
      {{1, "m"}, {1e-3, "mm"}, {1e-6, "µm"}, {1e-9, "nm"}, {1e-12, "pm"}}};
  const double size = std::abs(metres);
  for (const auto& [unit, name] : kPrefixes)
    if (size >= 0.9995 * unit) return fmt::format("{:.3g} {}", metres / unit, name);
  return size == 0 ? "0 m" : fmt::format("{:.2g} m", metres);
}

std::vector<std::string> sentences_of(const Comparison& comparison) {
  std::vector<std::string> sentences;
  add_reference(comparison, sentences);
  add_distances(comparison, sentences);
  add_gaps(comparison, sentences);
  add_failures(comparison, sentences);
  add_same(comparison, sentences);
  if (sentences.empty())
    sentences.push_back("There is nothing to compare: one run is all there is.");
  return sentences;
}

Json verdict_json(const Comparison& comparison) {
  const std::vector<Column> columns = columns_of(comparison);
  Json verdict = {{"columns", Json::array()}, {"rows", Json::array()}, {"sentences", {}}};
  for (const Column& column : columns)
    verdict["columns"].push_back({{"name", column.name},
                                  {"unit", column.unit},
                                  {"better", column.better == nullptr ? Json() : column.better}});
  for (const RunComparison& run : comparison.runs) {
    Json values = Json::array();
    for (const Column& column : columns) values.push_back(number_json(run.figure(column.figure)));
    verdict["rows"].push_back({{"variant", run.name}, {"values", std::move(values)}});
  }
  verdict["sentences"] = comparison.sentences;
  return verdict;
}

}  // namespace deform
