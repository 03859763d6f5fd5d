#include "plugin/common_parameters.h"

#include "deform/plugin/registry.h"

#include "plugin/fields_of.h"

namespace deform {

const ParameterFields& common_fields(PluginKind kind) {
  static const auto fields = per_kind<ParameterFields>(
      []<class Interface>() { return fields_of<CommonParameters<Interface>>(); });
  return fields[kind];
}

}  // namespace deform
