/// Scenes of any bytes are read, or refused with an InputError that says why; nothing else. A scene
/// that is read comes back from its completed text. A first line that starts with a slash is a
/// replacement as from --set: /POINTER=VALUE.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <spdlog/spdlog.h>

#include "deform/error.h"
#include "deform/simulation/scene.h"

namespace {

using namespace deform;

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

std::vector<Replacement> take_replacement(std::string_view& text) {
  if (!text.starts_with('/') || text.starts_with("//")) return {};
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  const std::size_t sign = std::min(line.find('='), line.size());
  return {{std::string(line.substr(0, sign)),
           std::string(line.substr(std::min(sign + 1, line.size())))}};
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer calls it so
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const PluginRegistry registry({DEFORM_PLUGINS});
  spdlog::set_level(spdlog::level::off);
  std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::vector<Replacement> replacements = take_replacement(text);
  Scene scene;
  try {
    scene = read_scene_text(std::string(text), "scene.json", ".", registry, replacements);
  } catch (const InputError& e) {
    require(!e.problems().empty(), "a refusal says why");
    for (const Problem& problem : e.problems()) require(!problem.message.empty(), "with words");
    return 0;
  }
  require(scene.steps() >= 1, "a scene has a step");
  const Scene again = read_scene_text(scene.completed, "scene.json", ".", registry);
  require(again.completed == scene.completed, "a completed scene is complete");
  return 0;
}
