#include "scene/scene_problems.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "json/json_pointer.h"

namespace deform {

bool SceneProblems::takes_no_more() {
  if (problems_.size() < kMost) return false;
  ++unlisted_;
  return true;
}

void SceneProblems::add(const std::string& pointer, const std::string& rule) {
  if (takes_no_more()) return;
  ScenePlace place = places_.of_value(pointer);
  problems_.push_back({pointer, place.at, std::move(place.source), rule});
}

void SceneProblems::add_missing_plugin(const std::string& pointer, const std::string& rule) {
  const std::size_t before = problems_.size();
  add(pointer, rule);
  if (problems_.size() > before) problems_.back().plugin_missing = true;
}

void SceneProblems::add_at_key(const std::string& pointer, const std::string& rule) {
  if (takes_no_more()) return;
  ScenePlace place = places_.of_key(pointer);
  problems_.push_back({pointer, place.at, std::move(place.source), rule});
}

void SceneProblems::add_unknown_key(const std::string& pointer, const std::string& rule) {
  unknown_keys_.push_back(pointer);
  add_at_key(pointer, rule);
}

void SceneProblems::add_outside(const std::string& source, const std::string& rule) {
  if (!takes_no_more()) problems_.push_back({"", {}, source, rule});
}

bool SceneProblems::any_within(const std::string& pointer) const {
  return unlisted_ > 0 || std::any_of(problems_.begin(), problems_.end(), [&](const auto& problem) {
           return is_within(problem.pointer, pointer);
         });
}

std::vector<SceneProblem> SceneProblems::sorted() const {
  std::vector<SceneProblem> sorted = problems_;
  const auto key = [](const SceneProblem& p) {
    const auto last = std::numeric_limits<std::size_t>::max();
    return std::tuple(p.at.known() ? p.at.line : last, p.at.column);
  };
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const SceneProblem& a, const SceneProblem& b) { return key(a) < key(b); });
  if (unlisted_ > 0) {
    sorted.push_back(
        {"", {}, document_.name(), "and " + std::to_string(unlisted_) + " more problems"});
  }
  return sorted;
}

Problem to_problem(const SceneProblem& problem, const std::string& variant) {
  std::string message = problem.source + ": ";
  if (!variant.empty()) message += "variant \"" + variant + "\": ";
  if (!problem.pointer.empty()) message += "at " + problem.pointer + ": ";
  return {problem.pointer, message + problem.rule};
}

SceneProblem to_scene_problem(const JsonProblem& problem, const std::string& file) {
  return {problem.pointer, problem.at, to_string(file, problem.at), problem.message};
}

}  // namespace deform
