/// The run that a new one replaces in its folder. It stays, set aside within the folder, until the
/// new one has taken its first step: what fails before has cost nothing.
#pragma once

#include <filesystem>

namespace deform {

/// Sets aside whatever the folder holds, but its lock. Throws Error when it cannot; InputError, and
/// changes nothing, where another process works in a folder within.
void set_old_run_aside(const std::filesystem::path& folder);

/// Removes what is new in the folder, and puts what was set aside in its place; nothing where
/// nothing was; removes what an earlier drop_old_run has left, where that can be removed. Throws
/// Error when something cannot be put back: calling it again goes on; InputError where another
/// process works in a folder within what is to go.
void give_old_run_back(const std::filesystem::path& folder);

/// Removes what was set aside; what of it cannot be removed stays under another name, in nobody's
/// way, and is warned of. Throws Error when it cannot be given up at all: it is then still there.
void drop_old_run(const std::filesystem::path& folder);

/// Whether something is set aside: by a run that has taken no step yet, or was killed before.
[[nodiscard]] bool has_old_run(const std::filesystem::path& folder);

/// Whether an entry of a run's folder is one of those that hold what was set aside.
[[nodiscard]] bool is_of_old_run(const std::filesystem::path& name);
/// Whether it is one whose content nobody wants any more.
[[nodiscard]] bool is_given_up(const std::filesystem::path& name);

}  // namespace deform
