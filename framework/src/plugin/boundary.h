#pragma once

#include <string>

#include "deform/error.h"

namespace deform {

/// Why a plugin failed, in words, from the exception in flight; call it in a catch block, while the
/// plugin's library is loaded.
std::string cause_of_current_exception();

/// "plugin force/wind (…/force-wind.so) failed while computing its force: out of ideas".
std::string failure_text(const std::string& origin, const char* doing, const std::string& cause);

/// True for failures that were reported at an inner boundary already: they name a library's file.
bool names_a_plugin(const Error& error);

}  // namespace deform
