/// The command line program: what it is told, and what it ends with.
#include <cstdlib>
#include <dlfcn.h>
#include <exception>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>

#include "deform/error.h"
#include "deform/plugin/process_end.h"
#include "deform/plugin/registry.h"
#include "deform/version.h"

#include "commit.h"
#include "compare_command.h"
#include "interrupt.h"
#include "mesh_command.h"
#include "plugin_command.h"
#include "plugins_command.h"
#include "progress.h"
#include "report_command.h"
#include "report_error.h"
#include "run_command.h"
#include "schema_command.h"
#include "terminal.h"
#include "validate_command.h"

namespace deform::app {
namespace {

constexpr const char* kFooter =
    "Exit codes: 0 done; 1 internal error, or a file cannot be written; 2 bad input; 3 the "
    "simulation diverged; 4 a plugin "
    "failed; "
    "5 an expectation failed; 130 interrupted.";

/// What the command line says; filled in while it is read.
struct Arguments {
  std::vector<std::filesystem::path> plugin_folders;
  std::size_t threads = 0;  // 0: as many as there are
  RunCommand run;
  CompareCommand compare;
  std::vector<std::string> sets, vary, shadows;
  std::string which_plugin;
  NewPlugin new_plugin;
  ContractOptions contract;
  std::vector<std::filesystem::path> scenes, meshes;
  bool repairs = false;
  std::filesystem::path schema_folder;
  std::filesystem::path report_folder;
  bool report_png = false;
};

Replacement parse_replacement(const std::string& text) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos || !text.starts_with('/')) {
    throw CLI::ValidationError("'" + text + "' is not of the form /POINTER=VALUE");
  }
  return {text.substr(0, sign), text.substr(sign + 1)};
}

Variation parse_variation(const std::string& text) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos || !text.starts_with('/')) {
    throw CLI::ValidationError("'" + text + "' is not of the form /POINTER=V1,V2,…");
  }
  return {text.substr(0, sign), split_values(text.substr(sign + 1))};
}

/// A file or folder, which "" is not: it would mean the default, or the folder that one is in.
const CLI::Validator& named() {
  static const CLI::Validator validator(
      [](const std::string& text) {
        return text.empty() ? std::string("an empty text names no file or folder") : std::string();
      },
      "", "named");
  return validator;
}

void add_set(CLI::App& command, Arguments& arguments, std::vector<Replacement>& replacements) {
  command
      .add_option("--set", arguments.sets,
                  "put VALUE (JSON, else a string) at a JSON pointer of the scene; may be repeated")
      ->type_name("PTR=VALUE")
      ->allow_extra_args(false)
      ->each([&replacements](const std::string& text) {
        replacements.push_back(parse_replacement(text));
      });
}

void add_shadow(CLI::App& command, Arguments& arguments, std::vector<Replacement>& replacements) {
  command
      .add_option("--shadow", arguments.shadows,
                  "normal estimators (names or JSON objects) to measure beside the run's own, on "
                  "the same states; may be repeated")
      ->type_name("N1,N2,…")
      ->allow_extra_args(false)
      ->each([&replacements](const std::string& text) {
        for (const std::string& estimator : split_values(text)) {
          replacements.push_back({"/shadow/-", estimator, false, "--shadow"});
        }
      });
}

void add_plugin_path(CLI::App& command, Arguments& arguments) {
  command
      .add_option("--plugin-path", arguments.plugin_folders, "folder to search for plugins first")
      ->type_name("DIR")
      ->allow_extra_args(false);
}

CLI::App& add_run(CLI::App& app, Arguments& arguments) {
  CLI::App& run = *app.add_subcommand("run", "Run a scene and record it");
  run.add_option("SCENE", arguments.run.scene, "scene file")
      ->required()
      ->type_name("")
      ->check(named());
  add_set(run, arguments, arguments.run.replacements);
  add_shadow(run, arguments, arguments.run.replacements);
  run.add_option("--variant", arguments.run.variant, "variant of the scene")->type_name("NAME");
  run.add_option("--out", arguments.run.folder, "run directory (default: runs/SCENE[-VARIANT])")
      ->type_name("DIR")
      ->check(named());
  CLI::Option* force =
      run.add_flag("--force", arguments.run.force, "replace an existing run directory");
  run.add_flag("--resume", arguments.run.resume,
               "go on from the checkpoint in the run directory; the same scene must be given")
      ->excludes(force);
  run.add_option("--threads", arguments.threads, "use at most N threads (default: all)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  run.add_flag("--profile", arguments.run.profile,
               "show where the time of the steps went; profile.txt and trace.json (for "
               "chrome://tracing, Perfetto) in the run directory");
  run.add_flag("--quiet", arguments.run.quiet, "no progress bar and no summary");
  run.add_flag("--part-of-comparison", arguments.run.part_of_comparison)->group("");
  add_plugin_path(run, arguments);
  return run;
}

CLI::App& add_compare(CLI::App& app, Arguments& arguments) {
  CLI::App& compare =
      *app.add_subcommand("compare", "Run a scene's variants and measure them against each other");
  ComparisonOptions& options = arguments.compare.options;
  compare.add_option("SCENE", options.request.scene, "scene file")
      ->required()
      ->type_name("")
      ->check(named());
  compare
      .add_option("--variants", arguments.compare.variants,
                  "variants to run (default: base and all; with --vary base alone)")
      ->type_name("A,B,…")
      ->allow_extra_args(false);
  compare
      .add_option("--vary", arguments.vary,
                  "values (JSON, else strings) to put at a JSON pointer, one a run; several make "
                  "the full grid")
      ->type_name("PTR=V1,V2,…")
      ->allow_extra_args(false)
      ->each([&options](const std::string& text) {
        options.request.variations.push_back(parse_variation(text));
      });
  add_set(compare, arguments, options.request.replacements);
  compare
      .add_option("--reference", options.request.reference,
                  "run to measure the others against; refined: the scene (refined:VARIANT: that "
                  "one) on a grid twice as fine with a quarter of the step")
      ->type_name("NAME");
  compare
      .add_option("--tolerance", options.request.tolerance,
                  "distance at which a run parts from the reference (default: 1 % of the size)")
      ->type_name("METRES")
      ->check(CLI::PositiveNumber);
  compare
      .add_option("--expect", options.expectation,
                  R"(claims to check, {"claims": ["a.flatness < b.flatness"]})")
      ->type_name("FILE")
      ->check(named());
  compare.add_option("--out", options.runner.folder, "folder (default: runs/SCENE-comparison)")
      ->type_name("DIR")
      ->check(named());
  CLI::Option* force =
      compare.add_flag("--force", options.force, "replace an existing comparison directory");
  compare
      .add_flag("--resume", options.runner.resume,
                "take over runs that are complete and unchanged, and go on with the others")
      ->excludes(force);
  compare.add_option("--jobs", options.runner.jobs, "runs at a time (default: 1)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  compare
      .add_option("--threads", arguments.compare.threads,
                  "threads of each run (default: those of the machine, over the jobs)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  compare.add_flag("--quiet", arguments.compare.quiet, "no progress bar and no table");
  add_plugin_path(compare, arguments);
  return compare;
}

CLI::App& add_plugins(CLI::App& app, Arguments& arguments) {
  CLI::App& plugins = *app.add_subcommand(
      "plugins", "List the plugins that are found; with a name, what that one offers");
  plugins.add_option("WHICH", arguments.which_plugin, "KIND, or KIND/NAME")->type_name("");
  add_plugin_path(plugins, arguments);
  return plugins;
}

CLI::App& add_plugin(CLI::App& app, Arguments& arguments) {
  CLI::App& plugin = *app.add_subcommand("plugin", "Begin a plugin of your own; test one");
  plugin.require_subcommand(1);

  CLI::App& make = *plugin.add_subcommand("new", "Write a project of a plugin that works");
  make.add_option("KIND", arguments.new_plugin.kind, "normal, energy, force, …: see deform plugins")
      ->required()
      ->type_name("");
  make.add_option("NAME", arguments.new_plugin.name, "what scenes call it")
      ->required()
      ->type_name("");
  make.add_option("--out", arguments.new_plugin.folder, "folder of the project (default: NAME)")
      ->type_name("DIR")
      ->check(named());

  CLI::App& check = *plugin.add_subcommand("check", "Test what a plugin promises");
  check.add_option("LIBRARY", arguments.contract.library, "KIND-NAME.so")
      ->required()
      ->type_name("")
      ->check(named());
  check
      .add_option("--parameters", arguments.contract.parameters,
                  "JSON object of the parameters to check it with; those that are required must be "
                  "there")
      ->type_name("JSON");
  check
      .add_option("--plugin-path", arguments.contract.folders,
                  "folder to search for what it names first")
      ->type_name("DIR")
      ->allow_extra_args(false);
  return plugin;
}

CLI::App& add_validate(CLI::App& app, Arguments& arguments) {
  CLI::App& validate = *app.add_subcommand(
      "validate", "Check scenes, all of their variants and everything that they name; run nothing");
  validate.add_option("SCENE", arguments.scenes, "scene files")
      ->required()
      ->type_name("")
      ->check(named());
  add_plugin_path(validate, arguments);
  return validate;
}

CLI::App& add_mesh(CLI::App& app, Arguments& arguments) {
  CLI::App& mesh =
      *app.add_subcommand("mesh", "Tell what the surface \"mesh\" sees in files; run nothing");
  mesh.add_option("FILE", arguments.meshes, "meshes: .obj, .ply, .stl, .off, .gltf or .glb")
      ->required()
      ->type_name("")
      ->check(named());
  mesh.add_flag("--repair", arguments.repairs, "mend what can be mended, and say what was");
  add_plugin_path(mesh, arguments);
  return mesh;
}

CLI::App& add_report(CLI::App& app, Arguments& arguments) {
  CLI::App& report = *app.add_subcommand(
      "report", "Make report.html of a run or comparison directory again, from what is in it");
  report.add_option("DIR", arguments.report_folder, "run or comparison directory")
      ->required()
      ->type_name("")
      ->check(named());
  report.add_flag("--png", arguments.report_png,
                  "and report.png, a contact sheet of variants and moments (needs Chromium)");
  return report;
}

CLI::App& add_schema(CLI::App& app, Arguments& arguments) {
  CLI::App& schema = *app.add_subcommand(
      "schema", "Print the JSON Schema of scenes, with the parameters of every plugin found");
  schema
      .add_option("--out", arguments.schema_folder,
                  "write it to a folder instead, and that of each plugin")
      ->type_name("DIR")
      ->check(named());
  add_plugin_path(schema, arguments);
  return schema;
}

/// One rule for all that makes threads: TBB, which the framework uses, and OpenMP, which what a
/// plugin links may use. BLAS is on one thread: see main.
std::unique_ptr<tbb::global_control> limit_threads(std::size_t threads) {
  using SetThreads = void(int);
  if (auto* const set_openmp = dlsym(RTLD_DEFAULT, "omp_set_num_threads"))
    reinterpret_cast<SetThreads*>(set_openmp)(static_cast<int>(threads));
  return std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                               threads);
}

/// Names of files start from it; one may have been removed under the shell.
void require_working_folder() {
  std::error_code error;
  (void)std::filesystem::current_path(error);
  if (error)
    throw InputError("the working directory is gone, or cannot be reached (" + error.message() +
                     "): change to one that is there");
}

/// Why the words that come first are no command; empty where they are one.
std::string objection_to_command(const CLI::App& app, int argc, char** argv) {
  const CLI::App* level = &app;
  for (int i = 1; i < argc && level->get_require_subcommand_min() > 0; ++i) {
    const std::string word = argv[i];
    if (word.starts_with('-')) return "";
    const CLI::App* next = nullptr;
    std::vector<std::string> names;
    for (const CLI::App* command : level->get_subcommands({})) {
      names.push_back(command->get_name());
      if (command->check_name(word)) next = command;
    }
    if (next == nullptr)
      return fmt::format("found \"{}\", expected a command: {}", word, fmt::join(names, ", "));
    level = next;
  }
  return "";
}

int execute(int argc, char** argv) {
  CLI::App app("Simulates elastically deformable surfaces; every choice is a plugin.", "deform");
  app.set_version_flag("--version", std::string("deform ") + version());
  app.require_subcommand(1);
  app.footer(kFooter);
  Arguments arguments;
  arguments.run.command_line.assign(argv, argv + argc);
  const CLI::App& run = add_run(app, arguments);
  arguments.compare.options.command_line = arguments.run.command_line;
  arguments.compare.options.commit = commit();
  const CLI::App& compare = add_compare(app, arguments);
  add_plugins(app, arguments);
  const CLI::App& plugin = add_plugin(app, arguments);
  const CLI::App& validate = add_validate(app, arguments);
  const CLI::App& mesh = add_mesh(app, arguments);
  const CLI::App& report = add_report(app, arguments);
  const CLI::App& schema = add_schema(app, arguments);
  if (const std::string why = objection_to_command(app, argc, argv); !why.empty()) {
    complain("{}", why);
    return static_cast<int>(ExitCode::bad_input);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    // Help and version are "errors" with code 0; all others are bad input, whatever CLI11's own
    // code.
    std::ostringstream help, trouble;
    const bool is_asked_for = app.exit(e, help, trouble) == 0;
    put_lines(help.str());
    std::istringstream lines(trouble.str());
    for (std::string line; std::getline(lines, line);) put_message(printable(line) + '\n');
    return is_asked_for ? 0 : static_cast<int>(ExitCode::bad_input);
  }

  require_working_folder();
  const auto limit = arguments.threads > 0 ? limit_threads(arguments.threads) : nullptr;
  static ProgressBar bar;  // the logger, which outlives this function, writes past it
  log_above(bar);
  if (plugin.got_subcommand("new")) return new_plugin(arguments.new_plugin);
  if (plugin.got_subcommand("check")) return check_plugin(arguments.contract);
  if (report.parsed()) return write_reports(arguments.report_folder, arguments.report_png);
  const auto registry = std::make_shared<const PluginRegistry>(arguments.plugin_folders);
  if (mesh.parsed()) return describe_meshes(arguments.meshes, arguments.repairs, *registry);
  if (validate.parsed()) return validate_scenes(arguments.scenes, registry);
  if (schema.parsed()) return write_schemas(*registry, arguments.schema_folder);
  if (compare.parsed()) {
    return compare_scene(arguments.compare, arguments.plugin_folders, registry, bar);
  }
  if (!run.parsed()) return list_plugins(*registry, arguments.which_plugin);
  return run_scene(arguments.run, registry, bar);
}

}  // namespace
}  // namespace deform::app

int main(int argc, char** argv) {
  deform::app::occupy_standard_streams();
  deform::app::prepare_signals();
  deform::watch_process_end();
  // Before any plugin brings OpenBLAS with it: its threads get in the way of ours, and let results
  // depend on their number.
  ::setenv("OPENBLAS_NUM_THREADS", "1", 0);
  int code = 0;
  try {
    code = deform::app::execute(argc, argv);
  } catch (...) {
    code = deform::app::report_current_error();
  }
  code = deform::app::finish_output(code);
  deform::expect_process_end();
  return code;
}
