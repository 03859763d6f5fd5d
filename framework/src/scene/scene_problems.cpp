#include "scene/scene_problems.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "scene/json_pointer.h"

namespace deform {
namespace {

std::string place(const std::string& file, SourcePosition at) {
  if (!at.known()) return file;
  return file + ':' + std::to_string(at.line) + ':' + std::to_string(at.column);
}

}  // namespace

void SceneProblems::moved(const std::string& pointer, const std::string& source_pointer) {
  origins_.push_back({pointer, source_pointer, ""});
}

void SceneProblems::moved_from_outside(const std::string& pointer, const std::string& source) {
  origins_.push_back({pointer, "", source});
}

void SceneProblems::add(const std::string& pointer, const std::string& rule) {
  add(pointer, rule, false);
}

void SceneProblems::add_at_key(const std::string& pointer, const std::string& rule) {
  add(pointer, rule, true);
}

void SceneProblems::add_outside(const std::string& source, const std::string& rule) {
  problems_.push_back({"", {}, source, rule});
}

void SceneProblems::add(const std::string& pointer, const std::string& rule, bool at_key) {
  const auto origin = std::find_if(origins_.rbegin(), origins_.rend(),
                                   [&](const Origin& o) { return is_within(pointer, o.pointer); });
  std::string source = pointer;
  if (origin != origins_.rend()) {
    if (!origin->outside.empty()) {
      problems_.push_back({pointer, {}, origin->outside, rule});
      return;
    }
    source = origin->source_pointer + pointer.substr(origin->pointer.size());
  }
  SourcePosition at = at_key ? document_.key_position(source) : document_.position(source);
  // What is missing, or was written out from a short form, has the place of what it belongs to.
  while (!at.known() && !source.empty()) {
    source = parent_pointer(source);
    at = document_.position(source);
  }
  problems_.push_back({pointer, at, place(document_.name(), at), rule});
}

std::vector<SceneProblem> SceneProblems::sorted() const {
  std::vector<SceneProblem> sorted = problems_;
  const auto key = [](const SceneProblem& p) {
    const auto last = std::numeric_limits<std::size_t>::max();
    return std::tuple(p.at.known() ? p.at.line : last, p.at.column);
  };
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const SceneProblem& a, const SceneProblem& b) { return key(a) < key(b); });
  return sorted;
}

Problem to_problem(const SceneProblem& problem, const std::string& variant) {
  std::string message = problem.source + ": ";
  if (!variant.empty()) message += "variant \"" + variant + "\": ";
  if (!problem.pointer.empty()) message += "at " + problem.pointer + ": ";
  return {problem.pointer, message + problem.rule};
}

SceneProblem to_scene_problem(const JsonProblem& problem, const std::string& file) {
  return {problem.pointer, problem.at, place(file, problem.at), problem.message};
}

}  // namespace deform
