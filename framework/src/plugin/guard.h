/// The exception boundary: whatever a plugin throws while it runs is reported with its name and
/// file.
#pragma once

#include <string>
#include <utility>

#include "deform/error.h"

#include "no_solver.h"
#include "not_finite.h"
#include "plugin/boundary.h"
#include "plugin/plugin_call.h"

namespace deform {

/// Calls f() for the plugin `origin`, who is `doing` something. Divergences pass, what ends an
/// interrupted step, and errors that name what failed: a plugin that this one called, a file that
/// cannot be written, a solver that cannot take a matrix. Anything else becomes a PluginFailure.
/// What is thrown is of the framework's own classes: it may outlive the plugin's library.
template <class F>
decltype(auto) guarded(const std::string& origin, const char* doing, F&& f) {
  const PluginCall call(origin, doing);
  try {
    return std::forward<F>(f)();
  } catch (const Diverged& diverged) {
    throw Diverged(diverged);
  } catch (const NotFinite& not_finite) {
    throw NotFinite(not_finite);
  } catch (const StepTooLong& too_long) {
    throw StepTooLong(too_long);
  } catch (const NoSolver& no_solver) {
    throw NoSolver(no_solver);
  } catch (const Error& error) {
    if (error.code() == ExitCode::diverged || error.code() == ExitCode::internal_error ||
        error.code() == ExitCode::interrupted)
      throw Error(error);
    if (names_a_plugin(error)) throw PluginFailure(error.what());
    throw PluginFailure(failure_text(origin, doing, error.what()));
  } catch (...) {
    throw PluginFailure(failure_text(origin, doing, cause_of_current_exception()));
  }
}

}  // namespace deform
