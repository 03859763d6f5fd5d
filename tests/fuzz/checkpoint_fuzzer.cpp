/// Checkpoints of any bytes are taken, or refused with an InputError; nothing else. The input is
/// tried as it is, and with a checksum that is right, which is what lets it through to the parser
/// and to the objects that get their memories back.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include <spdlog/spdlog.h>

#include "deform/error.h"

#include "simulation/checkpoint.h"
#include "simulation/memory_sections.h"
#include "simulation/run_parts.h"

namespace {

using namespace deform;

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

/// A simulation with its probes and outputs, begun.
class Target {
 public:
  Target()
      : registry_(std::make_shared<const PluginRegistry>(
            std::vector<std::filesystem::path>{DEFORM_PLUGINS})),
        parts_(make_run_parts(read_scene(DEFORM_FUZZ_SCENE, *registry_), registry_)) {
    begin_probes(parts_, make_run_context(parts_, {}));
  }

  void take(const Memory& memory) {
    load_section(*parts_.simulation, "simulation", memory);
    parts_.probes->load(memory);
    parts_.outputs->load(memory);
    require(parts_.simulation->state().r.allFinite(), "a state that was taken is finite");
    try {
      parts_.simulation->step();
      parts_.probes->follow(parts_.simulation->frame());
    } catch (const Error& e) {
      require(e.code() == ExitCode::diverged, "a step from any finite state at most diverges");
    }
  }

 private:
  std::shared_ptr<const PluginRegistry> registry_;
  RunParts parts_;
};

void try_content(std::string_view content) {
  static Target target;
  try {
    const Checkpoint checkpoint = decode_checkpoint(content, "checkpoint.bin");
    require(encoded(checkpoint) == content, "what is read is what was written");
    target.take(checkpoint.memory);
  } catch (const InputError& e) {
    require(!e.problems().empty(), "a refusal says why");
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer calls it so
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spdlog::set_level(spdlog::level::off);
  const std::string_view content(reinterpret_cast<const char*>(data), size);
  try_content(content);
  constexpr std::size_t kHashDigits = 64;
  try_content(sealed(std::string(content.substr(0, size - std::min(size, kHashDigits)))));
  return 0;
}
