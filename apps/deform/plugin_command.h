/// deform plugin new, deform plugin check
#pragma once

#include <filesystem>
#include <string>

#include "deform/check/contract.h"

namespace deform::app {

struct NewPlugin {
  std::string kind, name;
  std::filesystem::path folder;  ///< empty: the name
};

/// Writes a project of a plugin that can be built, checked and run as it is. Returns the exit code;
/// throws InputError for a bad kind or name, or a folder that exists, before anything is written.
int new_plugin(const NewPlugin& what);

/// Tests a plugin's contract and prints a table of what was found. Returns 0 when all passed, 5
/// when a check failed; throws InputError when the library does not load.
int check_plugin(const ContractOptions& options);

}  // namespace deform::app
