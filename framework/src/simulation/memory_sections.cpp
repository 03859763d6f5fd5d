#include "simulation/memory_sections.h"

#include <optional>

#include "deform/error.h"

#include "plugin/guard.h"

namespace deform {

void save_plugin(const Plugin& plugin, const std::string& origin, const std::string& section,
                 Memory& memory) {
  guarded(origin, "saving its memory", [&] { save_section(plugin, section, memory); });
}

void load_plugin(Plugin& plugin, const std::string& origin, const std::string& section,
                 const Memory& memory) {
  std::optional<std::string> misfit;  // of the checkpoint: no failure of the plugin's
  guarded(origin, "loading its memory", [&] {
    try {
      load_section(plugin, section, memory);
    } catch (const InputError& e) {
      misfit = e.what();
    }
  });
  if (misfit) throw InputError("plugin " + origin + ": " + *misfit);
}

}  // namespace deform
