/// The command line program: what it is told, and what it ends with.
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include "deform/error.h"
#include "deform/plugin/registry.h"
#include "deform/version.h"

#include "plugins_command.h"
#include "progress.h"
#include "run_command.h"

namespace deform::app {
namespace {

constexpr const char* kFooter =
    "Exit codes: 0 done; 1 internal error; 2 bad input; 3 the simulation diverged; 4 a plugin "
    "failed; "
    "5 an expectation failed; 130 interrupted.";

/// What the command line says; filled in while it is read.
struct Arguments {
  std::vector<std::filesystem::path> plugin_folders;
  std::size_t threads = 0;  // 0: as many as there are
  RunCommand run;
  std::vector<std::string> sets;
  std::string which_plugin;
};

Replacement parse_replacement(const std::string& text) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos || !text.starts_with('/')) {
    throw CLI::ValidationError("--set", "'" + text + "' is not of the form /POINTER=VALUE");
  }
  return {text.substr(0, sign), text.substr(sign + 1)};
}

void add_plugin_path(CLI::App& command, Arguments& arguments) {
  command
      .add_option("--plugin-path", arguments.plugin_folders, "folder to search for plugins first")
      ->type_name("DIR")
      ->allow_extra_args(false);
}

CLI::App& add_run(CLI::App& app, Arguments& arguments) {
  CLI::App& run = *app.add_subcommand("run", "Run a scene and record it");
  run.add_option("SCENE", arguments.run.scene, "scene file")->required()->type_name("");
  run.add_option("--set", arguments.sets,
                 "put VALUE (JSON, else a string) at a JSON pointer of the scene; may be repeated")
      ->type_name("PTR=VALUE")
      ->allow_extra_args(false)
      ->each([&arguments](const std::string& text) {
        arguments.run.replacements.push_back(parse_replacement(text));
      });
  run.add_option("--variant", arguments.run.variant, "variant of the scene")->type_name("NAME");
  run.add_option("--out", arguments.run.folder, "run directory (default: runs/SCENE[-VARIANT])")
      ->type_name("DIR");
  run.add_flag("--force", arguments.run.force, "replace an existing run directory");
  run.add_option("--threads", arguments.threads, "use at most N threads (default: all)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  run.add_flag("--quiet", arguments.run.quiet, "no progress bar and no summary");
  add_plugin_path(run, arguments);
  return run;
}

CLI::App& add_plugins(CLI::App& app, Arguments& arguments) {
  CLI::App& plugins = *app.add_subcommand(
      "plugins", "List the plugins that are found; with a name, what that one offers");
  plugins.add_option("WHICH", arguments.which_plugin, "KIND, or KIND/NAME")->type_name("");
  add_plugin_path(plugins, arguments);
  return plugins;
}

int execute(int argc, char** argv) {
  CLI::App app("Simulates elastically deformable surfaces; every choice is a plugin.", "deform");
  app.set_version_flag("--version", std::string("deform ") + version());
  app.require_subcommand(1);
  app.footer(kFooter);
  Arguments arguments;
  arguments.run.command_line.assign(argv, argv + argc);
  const CLI::App& run = add_run(app, arguments);
  add_plugins(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    // Help and version are "errors" with code 0; all others are bad input, whatever CLI11's own
    // code.
    return app.exit(e) == 0 ? 0 : static_cast<int>(ExitCode::bad_input);
  }

  std::optional<tbb::global_control> threads;
  if (arguments.threads > 0) {
    threads.emplace(tbb::global_control::max_allowed_parallelism, arguments.threads);
  }
  static ProgressBar bar;  // the logger, which outlives this function, writes past it
  log_above(bar);
  const auto registry = std::make_shared<const PluginRegistry>(arguments.plugin_folders);
  if (!run.parsed()) return list_plugins(*registry, arguments.which_plugin);
  return run_scene(arguments.run, registry, bar);
}

}  // namespace
}  // namespace deform::app

int main(int argc, char** argv) {
  // Before any plugin brings OpenBLAS with it: its threads get in the way of ours, and let results
  // depend on their number.
  ::setenv("OPENBLAS_NUM_THREADS", "1", 0);
  try {
    return deform::app::execute(argc, argv);
  } catch (const deform::InputError& e) {
    for (const deform::Problem& problem : e.problems()) {
      fmt::print(stderr, "deform: {}\n", problem.message);
    }
    return static_cast<int>(e.code());
  } catch (const deform::Error& e) {
    fmt::print(stderr, "deform: {}\n", e.what());
    return static_cast<int>(e.code());
  } catch (const std::exception& e) {
    fmt::print(stderr, "deform: internal error: {}\n", e.what());
    return static_cast<int>(deform::ExitCode::internal_error);
  }
}
