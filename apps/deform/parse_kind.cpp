#include "parse_kind.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "deform/error.h"

namespace deform::app {

PluginKind parse_kind(const std::string& text) {
  if (const auto kind = kind_named(text)) return *kind;
  throw InputError(fmt::format("there is no kind of plugin \"{}\"; kinds are {}", text,
                               fmt::join(kKindNames.values, ", ")));
}

}  // namespace deform::app
