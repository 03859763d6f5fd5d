#include "plugin/boundary.h"

#include <cxxabi.h>
#include <exception>
#include <string_view>
#include <typeinfo>

#include <boost/core/demangle.hpp>

namespace deform {

std::string cause_of_current_exception() {
  try {
    throw;
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    const std::type_info* const type = abi::__cxa_current_exception_type();
    if (type == nullptr) return "an exception from another language";
    return "an exception of type " + boost::core::demangle(type->name()) +
           ", which is no std::exception";
  }
}

std::string failure_text(const std::string& origin, const char* doing, const std::string& cause) {
  return "plugin " + origin + " failed while " + doing + ": " + cause;
}

bool names_a_plugin(const Error& error) {
  return error.code() == ExitCode::plugin_failed &&
         std::string_view(error.what()).find(".so)") != std::string_view::npos;
}

}  // namespace deform
