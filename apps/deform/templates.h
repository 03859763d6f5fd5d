/// The texts that `deform plugin new` fills in; apps/deform/templates, compiled into the program.
#pragma once

#include <span>
#include <string_view>

namespace deform::app {

struct Template {
  std::string_view file;  ///< "energy.cpp.in"
  std::string_view text;
};

[[nodiscard]] std::span<const Template> templates();

}  // namespace deform::app
