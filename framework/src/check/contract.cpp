#include "deform/check/contract.h"

#include <fmt/format.h>

#include "deform/error.h"

#include "check/contracts.h"
#include "json/json.h"
#include "plugin/plugin_call.h"

namespace deform {
namespace {

using Contract = void (*)(const Subject&, Checks&);

#define DEFORM_CONTRACT(name, plural, Interface) check_##name##_contract,
constexpr PerKind<Contract> kContracts{{DEFORM_PLUGIN_KINDS(DEFORM_CONTRACT)}};
#undef DEFORM_CONTRACT

void check_description(const Subject& subject, Checks& checks) {
  const LoadedPlugin& plugin = subject.plugin();
  const PluginText& text = plugin.descriptor().text;
  checks.holds("says its version and a summary", *text.version != '\0' && *text.summary != '\0',
               "one of them is empty");
  for (const ParameterField& field : plugin.fields())
    checks.holds("says what its parameters mean", !field.doc.empty(),
                 fmt::format("\"{}\" has no explanation", field.name));
}

/// A scene that was completed with the defaults must be one that can be read again.
void check_defaults(const Subject& subject, const Scene& scene, Checks& checks) {
  checks.runs("its defaults keep its own rules", [&] {
    (void)read_scene_text(scene.completed, kCheckedScene, ".", *subject.registry());
  });
}

Json parse_parameters(const std::string& text) {
  Json parameters = Json::parse(text, nullptr, false);
  if (!parameters.is_object()) {
    throw InputError("the parameters must be a JSON object like {\"stiffness\": 2.0}, found " +
                     text);
  }
  return parameters;
}

/// Throws InputError for parameters that the plugin rejects, without the place in a scene that the
/// user never wrote.
Scene scene_to_begin_with(const Subject& subject) {
  try {
    return subject.scene(terrains(9, 7).front());
  } catch (const InputError& error) {
    std::vector<Problem> problems = error.problems();
    for (Problem& problem : problems) {
      if (!problem.message.starts_with(kCheckedScene)) continue;
      const std::size_t end = problem.message.find(": ", std::string_view(kCheckedScene).size());
      if (end != std::string::npos) problem.message.erase(0, end + 2);
    }
    problems.push_back({"", "say what it needs with --parameters '{\"NAME\": VALUE, …}'"});
    throw InputError(problems);
  }
}

}  // namespace

ContractReport check_contract(const ContractOptions& options) {
  const LoadedPlugin alone = load_plugin(options.library);
  const auto registry = std::make_shared<const PluginRegistry>(options.folders, options.library);
  const PluginFile& file = alone.file();
  const LoadedPlugin& plugin = registry->load(file.kind, file.name);
  const Subject subject(registry, plugin, parse_parameters(options.parameters));

  ContractReport report{plugin.origin(), {}};
  // What checks call by themselves ends the process in the name of the plugin, too.
  const std::string who = plugin.origin();
  const PluginCall call(who, "being checked");
  Checks checks(report.lines);
  const Scene scene = scene_to_begin_with(subject);
  check_description(subject, checks);
  check_defaults(subject, scene, checks);
  kContracts[file.kind](subject, checks);
  return report;
}

}  // namespace deform
