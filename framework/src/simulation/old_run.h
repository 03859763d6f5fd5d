/// The run that a new one replaces in its folder. It stays, set aside within the folder, until the
/// new one has taken its first step: what fails before has cost nothing.
#pragma once

#include <filesystem>

namespace deform {

/// Sets aside whatever the folder holds, but its lock. Throws Error when it cannot.
void set_old_run_aside(const std::filesystem::path& folder);

/// Removes what is new in the folder, and puts what was set aside in its place; nothing where
/// nothing was. Throws Error when it cannot: calling it again goes on.
void give_old_run_back(const std::filesystem::path& folder);

/// Removes what was set aside. Throws Error when it cannot.
void drop_old_run(const std::filesystem::path& folder);

/// Whether something is set aside: by a run that has taken no step yet, or was killed before.
[[nodiscard]] bool has_old_run(const std::filesystem::path& folder);

}  // namespace deform
