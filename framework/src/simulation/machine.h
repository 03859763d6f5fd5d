/// What a run is made on and with: for manifests.
#pragma once

#include <string>

#include "json/json.h"

namespace deform {

[[nodiscard]] std::string host_name();
/// As the operating system calls it; empty where it does not say.
[[nodiscard]] std::string cpu_model();
/// Compiler, and the libraries that are compiled in.
[[nodiscard]] Json built_with();
/// The shared libraries that the process has loaded so far, without plugins and the system's own:
/// of each its file, whose name ends with its version.
[[nodiscard]] Json loaded_libraries();
/// File and hash of the framework's own library.
[[nodiscard]] Json own_library();

}  // namespace deform
