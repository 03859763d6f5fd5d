#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/plugin/registry.h"

#include "parse_kind.h"
#include "plugin_command.h"
#include "templates.h"
#include "terminal.h"

namespace deform::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLastSection = "  \"duration\":";

/// "saint_venant" to "SaintVenantPlugin": the ending keeps it apart from the framework's names.
std::string class_name(const std::string& name) {
  std::string text;
  bool starts_word = true;
  for (const char c : name) {
    if (c == '_') {
      starts_word = true;
      continue;
    }
    text += starts_word ? static_cast<char>(std::toupper(c)) : c;
    starts_word = false;
  }
  return text + "Plugin";
}

/// What stands in a template for "@word@".
using Words = std::map<std::string, std::string>;

std::string filled_in(const std::string& file, const Words& words) {
  const auto found = std::ranges::find(templates(), file, &Template::file);
  std::string text(found->text);
  for (const auto& [word, value] : words) {
    const std::string place = '@' + word + '@';
    for (std::size_t at = text.find(place); at != std::string::npos; at = text.find(place, at))
      text.replace(at, place.size(), value);
  }
  return text;
}

/// The scene of all projects, in which the section that the kind's template gives, a line, takes
/// the place of the one with its key. The last line of a scene is no plugin's.
std::string scene_text(const Words& words) {
  std::string scene = filled_in("scene.json.in", words);
  std::string section = filled_in(words.at("kind") + ".scene.in", words);
  section.replace(section.find('\n'), 1, ",\n");
  const std::size_t found = scene.find(section.substr(0, section.find(':') + 1));
  if (found == std::string::npos) return scene.insert(scene.find(kLastSection), section);
  return scene.replace(found, scene.find('\n', found) + 1 - found, section);
}

void check(const NewPlugin& what, const fs::path& folder) {
  const PluginKind kind = parse_kind(what.kind);
  if (!is_plugin_name(what.name)) {
    throw InputError(
        fmt::format("\"{}\" is no name for a plugin: it must begin with a letter a to "
                    "z and go on with these, digits and underscores",
                    what.name));
  }
  const PluginRegistry registry;
  for (const PluginFile& file : registry.files()) {
    if (file.kind != kind || file.name != what.name) continue;
    throw InputError(
        fmt::format("there is a plugin {}/{} already, {}: a scene that names it could mean either, "
                    "and would be refused; choose another name",
                    what.kind, what.name, file.path.string()));
  }
  if (fs::exists(fs::symlink_status(folder))) {
    throw InputError(fmt::format("{} exists: name another folder with --out", folder.string()));
  }
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) {
    throw Error(ExitCode::internal_error, "cannot write " + file.string());
  }
}

}  // namespace

int new_plugin(const NewPlugin& what) {
  const fs::path folder = what.folder.empty() ? fs::path(what.name) : what.folder;
  check(what, folder);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(fmt::format("cannot make {}: {}", folder.string(), error.message()));

  const Words words{{"kind", what.kind}, {"name", what.name}, {"Class", class_name(what.name)}};
  write(folder / (what.name + ".cpp"), filled_in(what.kind + ".cpp.in", words));
  for (const char* const file : {"CMakeLists.txt", "README.md"})
    write(folder / file, filled_in(std::string(file) + ".in", words));
  write(folder / "scene.json", scene_text(words));

  const std::string where = folder.string();
  say("{0}: a plugin {1}/{2} that works; change {2}.cpp to make it yours\n\n"
      "  cmake -S {0} -B {0}/build && cmake --build {0}/build\n"
      "  deform plugin check {0}/build/{1}-{2}.so\n"
      "  deform run {0}/scene.json --plugin-path {0}/build --out {0}/run\n",
      where, what.kind, what.name);
  return static_cast<int>(ExitCode::done);
}

}  // namespace deform::app
