#pragma once

#include <string>

#include "json/json.h"

namespace deform {

/// The draft of JSON Schema that all schemas are written in.
inline constexpr const char* kJsonSchemaDraft = "https://json-schema.org/draft/2020-12/schema";

/// A schema as a file has it.
inline std::string schema_text(const Json& schema) {
  return schema.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace deform
