#include "plugins_command.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "deform/error.h"

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
  fmt::print("{}\n", name_of(kind));
  for (const std::string& name : names) {
    fmt::print("  {:<{}}  {}\n", name, width, summary_of(registry, kind, name));
  }
}

void print_folders(const PluginRegistry& registry) {
  fmt::print("\nfolders searched\n");
  for (const SearchFolder& folder : registry.folders()) {
    const bool exists = std::filesystem::is_directory(folder.path);
    fmt::print("  {} ({}{})\n", folder.path.string(), folder.said_by,
               exists ? "" : ", does not exist");
  }
}

using Row = std::array<std::string, 6>;

std::vector<Row> parameter_rows(const LoadedPlugin& plugin) {
  std::vector<Row> rows{{"parameter", "type", "unit", "default", "range", "meaning"}};
  for (const auto* fields : {&common_fields(plugin.file().kind), &plugin.fields()}) {
    for (const ParameterField& field : *fields) {
      const ParameterText text = describe(field);
      rows.push_back({field.name, text.type, field.unit,
                      field.required ? "required" : text.default_value, text.range, field.doc});
    }
  }
  return rows;
}

/// Characters of a UTF-8 text: its bytes that do not continue one.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
  }));
}

/// Columns side by side; the last one is as long as it is.
void print_table(const std::vector<Row>& rows) {
  std::array<std::size_t, std::tuple_size_v<Row>> widths{};
  for (const Row& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      widths[c] = std::max(widths[c], width_of(row[c]));
    }
  }
  for (const Row& row : rows) {
    std::string line = " ";
    for (std::size_t c = 0; c + 1 < row.size(); ++c) {
      line += fmt::format(" {:<{}} ", row[c], widths[c]);
    }
    fmt::print("{} {}\n", line, row.back());
  }
}

void print_line(const char* label, const std::string& text) {
  if (!text.empty()) fmt::print("  {:<8} {}\n", label, text);
}

void print_one(const LoadedPlugin& plugin) {
  const PluginText& text = plugin.descriptor().text;
  const PluginFile& file = plugin.file();
  fmt::print("{}/{} {}\n", name_of(file.kind), file.name, text.version);
  print_line("summary", text.summary);
  print_line("formula", text.formula);
  print_line("source", text.source);
  print_line("file", file.path.string());
  const auto rows = parameter_rows(plugin);
  if (rows.size() == 1) {
    fmt::print("\n  no parameters\n");
  } else {
    fmt::print("\n");
    print_table(rows);
  }
}

PluginKind parse_kind(const std::string& text) {
  const auto found = std::find(kPluginKinds.begin(), kPluginKinds.end(), text);
  if (found == kPluginKinds.end()) {
    throw InputError(fmt::format("there is no kind of plugin \"{}\"; kinds are {}", text,
                                 fmt::join(kPluginKinds, ", ")));
  }
  return static_cast<PluginKind>(found - kPluginKinds.begin());
}

}  // namespace

int list_plugins(const PluginRegistry& registry, const std::string& which) {
  if (const std::size_t slash = which.find('/'); slash != std::string::npos) {
    const PluginKind kind = parse_kind(which.substr(0, slash));
    print_one(registry.load(kind, which.substr(slash + 1)));
    return static_cast<int>(ExitCode::done);
  }
  if (which.empty()) {
    for (const std::string_view kind : kPluginKinds)
      print_kind(registry, parse_kind(std::string(kind)));
  } else {
    print_kind(registry, parse_kind(which));
  }
  print_folders(registry);
  return static_cast<int>(ExitCode::done);
}
