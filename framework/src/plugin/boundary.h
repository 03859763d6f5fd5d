#pragma once

#include <string>

namespace deform {

/// Why a plugin failed, in words, from the exception in flight; call it in a catch block, while the
/// plugin's library is loaded.
std::string cause_of_current_exception();

}  // namespace deform
