#include "validate_command.h"

#include <algorithm>
#include <set>
#include <string>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/log.h"
#include "deform/simulation/run.h"
#include "deform/simulation/scene.h"

#include "report_error.h"
#include "terminal.h"

namespace deform::app {
namespace {

/// Where the value stands and what is wrong with it, whichever variant it is told of.
std::string told(const Scene& scene, const Problem& problem) {
  const std::string front = scene.located({problem.pointer, ""}).message;
  const bool placed = problem.message.starts_with(front);
  return scene.place(problem.pointer) + problem.message.substr(placed ? front.size() : 0);
}

/// Throws InputError with the problems of all variants; what they share is said once. Warns of what
/// is no error, once, too.
void check_all(const std::vector<Scene>& scenes,
               const std::shared_ptr<const PluginRegistry>& registry) {
  std::vector<Problem> problems, warnings;
  std::set<std::string> known;
  for (const Scene& scene : scenes) {
    try {
      for (const Problem& remark : check(scene, registry)) {
        if (known.insert(told(scene, remark)).second) warnings.push_back(remark);
      }
    } catch (const InputError& error) {
      for (const Problem& problem : error.problems()) {
        if (known.insert(told(scene, problem)).second) problems.push_back(problem);
      }
    }
  }
  if (!problems.empty()) throw InputError(problems);
  for (const Problem& warning : warnings) log::warn(warning.message);
}

}  // namespace

int validate_scenes(const std::vector<std::filesystem::path>& files,
                    const std::shared_ptr<const PluginRegistry>& registry) {
  int code = static_cast<int>(ExitCode::done);
  for (const std::filesystem::path& file : files) {
    try {
      const std::vector<Scene> scenes = read_variants(file, *registry);
      check_all(scenes, registry);
      const std::size_t variants = scenes.size() - 1;
      say("{}: ok ({} variant{})\n", file.string(), variants, variants == 1 ? "" : "s");
    } catch (...) {
      code = std::max(code, report_current_error());
    }
  }
  return code;
}

}  // namespace deform::app
