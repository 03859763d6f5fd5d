#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "deform/error.h"
#include "deform/plugin/registry.h"

#include "plugin_command.h"
#include "templates.h"
#include "terminal.h"

namespace deform::app {
namespace {

namespace fs = std::filesystem;

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

/// The sections of a scene in which the plugin stands in its place.
std::string scene_text(const std::string& kind, const std::string& name) {
  const std::string use = fmt::format(R"({{ "plugin": "{}" }})", name);
  std::vector<std::pair<std::string, std::string>> sections{
      {"title", fmt::format("\"{}/{}\"", kind, name)},
      {"surface", R"({ "plugin": "grid", "nodes": [21, 21], "size": [1.0, 1.0] })"},
      {"material", R"({ "density": 0.1, "damping": 1.0 })"},
      {"energies",
       R"([ { "plugin": "stretching", "eta": 1.0 }, { "plugin": "bending_variational" } ])"},
      {"forces", R"([ { "plugin": "gravity", "acceleration": [0, 0, -1] } ])"},
      {"constraints", R"([ { "plugin": "pin", "where": { "boundary": "left" } } ])"},
      {"colliders", ""},
      {"integrator", R"({ "plugin": "semi_implicit", "step": 0.002 })"},
      {"solver", ""},
      {"duration", "0.2"},
      {"outputs", R"([ { "plugin": "vtk", "every": 20 } ])"},
      {"probes", R"([ "energy", "lowest" ])"},
  };
  const auto put = [&sections](const std::string& key, const std::string& text) {
    std::ranges::find(sections, key, &std::pair<std::string, std::string>::first)->second = text;
  };
  if (kind == "surface") put("surface", use);
  if (kind == "shape")
    put("surface", fmt::format(R"({{ "plugin": "grid", "nodes": [21, 21], "rest": {} }})", use));
  if (kind == "normal")
    put("energies",
        fmt::format(
            R"([ {{ "plugin": "stretching", "eta": 1.0 }}, {{ "plugin": "bending", "normal": {} }} ])",
            use));
  if (kind == "energy")
    put("energies",
        fmt::format(
            R"([ {{ "plugin": "stretching", "eta": 1.0 }}, {{ "plugin": "bending_variational" }}, {} ])",
            use));
  if (kind == "force")
    put("forces",
        fmt::format(R"([ {{ "plugin": "gravity", "acceleration": [0, 0, -1] }}, {} ])", use));
  if (kind == "constraint")
    put("constraints",
        fmt::format(R"([ {{ "plugin": "{}", "where": {{ "boundary": "left" }} }} ])", name));
  if (kind == "collider") put("colliders", fmt::format("[ {} ]", use));
  if (kind == "integrator")
    put("integrator", fmt::format(R"({{ "plugin": "{}", "step": 0.0005 }})", name));
  if (kind == "solver") put("solver", use);
  if (kind == "output")
    put("outputs", fmt::format(R"([ {{ "plugin": "{}", "every": 20 }} ])", name));
  if (kind == "probe") put("probes", fmt::format(R"([ "energy", "lowest", "{}" ])", name));

  std::erase_if(sections, [](const auto& section) { return section.second.empty(); });
  std::vector<std::string> lines;
  lines.reserve(sections.size());
  for (const auto& [key, text] : sections) lines.push_back(fmt::format("  \"{}\": {}", key, text));
  return fmt::format("{{\n{}\n}}\n", fmt::join(lines, ",\n"));
}

std::string filled_in(const std::string& file, const std::map<std::string, std::string>& words) {
  const auto found = std::ranges::find(templates(), file, &Template::file);
  std::string text(found->text);
  for (const auto& [word, value] : words) {
    const std::string place = '@' + word + '@';
    for (std::size_t at = text.find(place); at != std::string::npos; at = text.find(place, at))
      text.replace(at, place.size(), value);
  }
  return text;
}

void check(const NewPlugin& what, const fs::path& folder) {
  if (std::ranges::find(kPluginKinds, what.kind) == kPluginKinds.end()) {
    throw InputError(fmt::format("there is no kind of plugin \"{}\"; kinds are {}", what.kind,
                                 fmt::join(kPluginKinds, ", ")));
  }
  if (!is_plugin_name(what.name)) {
    throw InputError(
        fmt::format("\"{}\" is no name for a plugin: it must begin with a letter a to "
                    "z and go on with these, digits and underscores",
                    what.name));
  }
  const PluginRegistry registry;
  for (const PluginFile& file : registry.files()) {
    if (name_of(file.kind) != what.kind || file.name != what.name) continue;
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

  const std::map<std::string, std::string> words{
      {"kind", what.kind}, {"name", what.name}, {"Class", class_name(what.name)}};
  write(folder / (what.name + ".cpp"), filled_in(what.kind + ".cpp.in", words));
  for (const char* const file : {"CMakeLists.txt", "README.md"})
    write(folder / file, filled_in(std::string(file) + ".in", words));
  write(folder / "scene.json", scene_text(what.kind, what.name));

  const std::string where = folder.string();
  say("{0}: a plugin {1}/{2} that works; change {2}.cpp to make it yours\n\n"
      "  cmake -S {0} -B {0}/build && cmake --build {0}/build\n"
      "  deform plugin check {0}/build/{1}-{2}.so\n"
      "  deform run {0}/scene.json --plugin-path {0}/build --out {0}/run\n",
      where, what.kind, what.name);
  return static_cast<int>(ExitCode::done);
}

}  // namespace deform::app
