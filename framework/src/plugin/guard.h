/// The exception boundary: whatever a plugin throws while it runs is reported with its name and file.
#pragma once

#include <exception>
#include <string>
#include <utility>

#include "deform/error.h"

namespace deform {

/// Calls f() for the plugin `origin`, who is `doing` something. Failures that are named already and divergences
/// pass; anything else becomes a PluginFailure.
template <class F>
decltype(auto) guarded(const std::string& origin, const char* doing, F&& f) {
  const auto fail = [&](const std::string& cause) -> PluginFailure {
    return PluginFailure("plugin " + origin + " failed while " + doing + ": " + cause);
  };
  try {
    return std::forward<F>(f)();
  } catch (const PluginFailure&) {
    throw;
  } catch (const Diverged&) {
    throw;
  } catch (const Error& error) {
    if (error.code() == ExitCode::diverged) throw;
    throw fail(error.what());
  } catch (const std::exception& error) {
    throw fail(error.what());
  } catch (...) {
    throw fail("it threw something that is not a std::exception");
  }
}

}  // namespace deform
