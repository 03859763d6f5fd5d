#include "schema_command.h"

#include <fstream>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/simulation/scene.h"

#include "terminal.h"

namespace deform::app {
namespace {

namespace fs = std::filesystem;

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw InputError(fmt::format("--out: cannot make {}: {}", folder.string(), error.message()));
  }
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw Error(ExitCode::internal_error, fmt::format("cannot write {}", file.string()));
}

}  // namespace

int write_schemas(const PluginRegistry& registry, const fs::path& folder) {
  const std::string schema = scene_schema(registry);
  if (folder.empty()) {
    put_lines(schema);
    return static_cast<int>(ExitCode::done);
  }
  const fs::path plugins = folder / "plugins";
  make_folder(plugins);
  write(folder / "scene.schema.json", schema);
  for (const PluginFile& file : registry.files()) {
    try {
      const LoadedPlugin& plugin = registry.load(file.kind, file.name);
      write(plugins / fmt::format("{}-{}.schema.json", name_of(file.kind), file.name),
            parameter_schema(plugin));
    } catch (const InputError&) {
      continue;  // scene_schema has said why it is left out
    }
  }
  return static_cast<int>(ExitCode::done);
}

}  // namespace deform::app
