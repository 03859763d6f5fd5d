/// The folder that a run is recorded in.
#pragma once

#include <filesystem>

namespace deform {

/// By it a folder is known as one of deform's.
inline constexpr const char* kManifestFile = "manifest.json";

/// Throws InputError when a run must not be recorded there: something is there and `force` is
/// false, or what is there is neither an empty folder nor one that deform made. Changes nothing.
void check_run_directory(const std::filesystem::path& folder, bool force);

/// Makes the folder, with its parents, where it is not there; changes nothing where it is: somebody
/// else may have made it meanwhile. Throws Error when it cannot be made.
void make_run_directory(const std::filesystem::path& folder);

/// Removes all that a folder holds but its lock (check_run_directory comes first, and whoever
/// empties it holds it). Throws Error when it cannot; InputError where another process works in a
/// folder within.
void empty_run_directory(const std::filesystem::path& folder);

/// True where a folder has nothing in it but its lock, what a run that was killed while it wrote
/// its first file has left, or what could not be removed of an old run (is_given_up). Throws
/// InputError when one cannot look into it.
[[nodiscard]] bool holds_nothing(const std::filesystem::path& folder);

/// True for a folder with a manifest.json that deform wrote.
[[nodiscard]] bool has_manifest(const std::filesystem::path& folder);

}  // namespace deform
