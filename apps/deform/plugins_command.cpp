#include "plugins_command.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "deform/error.h"

#include "parse_kind.h"
#include "table.h"
#include "terminal.h"

namespace {
using namespace deform;

/// One line about a library; one that does not load is listed with the reason.
std::string summary_of(const PluginRegistry& registry, PluginKind kind, const std::string& name) {
  try {
    return registry.load(kind, name).descriptor().text.summary;
  } catch (const InputError& error) {
    return fmt::format("DOES NOT LOAD: {}", error.what());
  }
}

void print_kind(const PluginRegistry& registry, PluginKind kind) {
  const auto names = registry.names(kind);
  if (names.empty()) return;
  std::size_t width = 0;
  for (const PluginFile& file : registry.files()) width = std::max(width, file.name.size());
  app::say("{}\n", name_of(kind));
  for (const std::string& name : names) {
    app::print_wrapped(fmt::format("  {:<{}}  ", name, width), summary_of(registry, kind, name));
  }
}

void print_folders(const PluginRegistry& registry) {
  app::say("\nfolders searched\n");
  for (const SearchFolder& folder : registry.folders()) {
    const bool exists = std::filesystem::is_directory(folder.path);
    app::say("  {} ({}{})\n", folder.path.string(), folder.said_by,
             exists ? "" : ", does not exist");
  }
}

using Rows = std::vector<std::vector<std::string>>;

/// The parameters of a plugin, the framework's own for its kind first.
std::vector<ParameterField> all_fields(const LoadedPlugin& plugin) {
  std::vector<ParameterField> fields = common_fields(plugin.file().kind);
  fields.insert(fields.end(), plugin.fields().begin(), plugin.fields().end());
  return fields;
}

Rows parameter_rows(const LoadedPlugin& plugin) {
  Rows rows{{"parameter", "type", "unit", "default", "range", "meaning"}};
  for (const ParameterField& field : all_fields(plugin)) {
    const ParameterText text = describe(field);
    rows.push_back({field.name, text.type, field.unit == "1" ? "" : field.unit,
                    field.required ? "required" : text.default_value, text.range, field.doc});
  }
  return rows;
}

/// The least that a scene must say: {"plugin": "point_load", "force": [x, y, z], …}.
std::string least_use(const LoadedPlugin& plugin) {
  std::string text = fmt::format(R"({{ "plugin": "{}")", plugin.file().name);
  for (const ParameterField& field : all_fields(plugin)) {
    if (field.required) text += fmt::format(", \"{}\": {}", field.name, describe(field).type);
  }
  return text + " }";
}

void print_line(const char* label, const std::string& text) {
  if (!text.empty()) app::print_wrapped(fmt::format("  {:<8} ", label), text);
}

void print_one(const LoadedPlugin& plugin) {
  const PluginText& text = plugin.descriptor().text;
  const PluginFile& file = plugin.file();
  app::say("{}/{} {}\n", name_of(file.kind), file.name, text.version);
  print_line("summary", text.summary);
  print_line("formula", text.formula);
  print_line("source", text.source);
  print_line("file", file.path.string());
  print_line("scene", least_use(plugin));
  const Rows rows = parameter_rows(plugin);
  if (rows.size() == 1) {
    app::say("\n  no parameters\n");
  } else {
    app::say("\n");
    app::print_table(rows);
  }
}

}  // namespace

int list_plugins(const PluginRegistry& registry, const std::string& which) {
  if (const std::size_t slash = which.find('/'); slash != std::string::npos) {
    const PluginKind kind = app::parse_kind(which.substr(0, slash));
    print_one(registry.load(kind, which.substr(slash + 1)));
    return static_cast<int>(ExitCode::done);
  }
  if (which.empty()) {
    for (const PluginKind kind : kPluginKinds) print_kind(registry, kind);
  } else {
    print_kind(registry, app::parse_kind(which));
  }
  print_folders(registry);
  return static_cast<int>(ExitCode::done);
}
