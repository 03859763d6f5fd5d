#include "simulation/json_file.h"

#include "simulation/files.h"

namespace deform {

Json read_json_object(const std::filesystem::path& file) {
  const auto text = read_file(file);
  Json json = text ? Json::parse(*text, nullptr, false) : Json();
  return json.is_object() ? json : Json();
}

}  // namespace deform
