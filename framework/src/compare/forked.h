/// What may end the process, done in a copy of it.
#pragma once

#include <atomic>
#include <functional>
#include <string>

namespace deform {

/// Calls `make` in a child of this process, and returns what it returns; throws what it throws, as
/// InputError or Error of that code. A child that ends within `make` is a PluginFailure with how it
/// ended. Throws Error with ExitCode::interrupted, the child being killed, when `interrupted`
/// becomes true. Where this process has several threads already, of which a child would have but
/// one, and locks that nobody opens, `make` is called here.
[[nodiscard]] std::string in_child(const std::function<std::string()>& make,
                                   const std::atomic<bool>* interrupted);

}  // namespace deform
