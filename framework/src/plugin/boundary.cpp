#include "plugin/boundary.h"

#include <cxxabi.h>
#include <exception>
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

}  // namespace deform
