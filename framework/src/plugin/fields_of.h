#pragma once

#include "deform/plugin/declaration.h"

namespace deform {

/// The fields that `Parameters::declare` declares.
template <class Parameters>
ParameterFields fields_of() {
  ParameterFields fields;
  Declaration<Parameters> declaration(fields);
  Parameters::declare(declaration);
  return fields;
}

}  // namespace deform
