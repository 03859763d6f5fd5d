#include "deform/plugin/declaration.h"

namespace deform {

ParameterField::ParameterField() = default;
ParameterField::~ParameterField() = default;
ParameterField::ParameterField(const ParameterField& other) = default;
ParameterField::ParameterField(ParameterField&& other) noexcept = default;
ParameterField& ParameterField::operator=(const ParameterField& other) = default;
ParameterField& ParameterField::operator=(ParameterField&& other) noexcept = default;

ParameterField& add_field(ParameterFields& fields, const char* name, const char* unit,
                          const char* doc, const ParameterValue& default_value) {
  ParameterField& field = fields.emplace_back();
  field.name = name;
  field.unit = unit;
  field.doc = doc;
  field.default_value = default_value;
  return field;
}

}  // namespace deform
