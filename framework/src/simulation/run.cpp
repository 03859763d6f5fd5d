#include "deform/simulation/run.h"

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "simulation/recording.h"

namespace deform {
namespace {

constexpr const char* kNothingWritten = "interrupted before the first step; nothing was written";

RunResult already_finished(const Scene& scene, const std::filesystem::path& folder) {
  RunResult result;
  result.reason = fmt::format("'{}' holds the finished run of this scene: nothing was left to do",
                              folder.string());
  result.steps = result.resumed_after = scene.steps();
  return result;
}

}  // namespace

RunResult run(const Scene& scene, std::shared_ptr<const PluginRegistry> registry,
              const RunOptions& options) {
  HeldFolder held(options.folder, options.resume  ? FolderUse::resumed
                                  : options.force ? FolderUse::replaced
                                                  : FolderUse::made);
  Manifest manifest(scene, *registry, options);
  Resumption found;
  if (options.resume) {
    found = look_for_run(options.folder, scene, manifest);
    if (found.finished) return already_finished(scene, options.folder);
  }
  StepWatch watch(options.interrupted);
  std::optional<Recording> recording;
  {
    const std::function<void()> give_up = [&options] {
      RunResult result;
      result.code = ExitCode::interrupted;
      result.reason = kNothingWritten;
      if (options.abandon) options.abandon(result);
    };
    const StepWatch::Span watched(watch, give_up);
    recording.emplace(scene, std::move(registry), options, std::move(manifest), std::move(found),
                      std::move(held), watch);
  }
  if (options.interrupted != nullptr && options.interrupted->load())
    throw Error(ExitCode::interrupted, kNothingWritten);
  return recording->execute();
}

}  // namespace deform
