#include "simulation/scene_files.h"

#include <cstddef>
#include <system_error>

#include <fmt/format.h>

#include "deform/error.h"

#include "files/sha256.h"
#include "json/json_file.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

/// The member that a pointer names; null where there is none.
template <class Object>
Object* member_at(Object& json, const std::string& pointer) {
  const typename Object::json_pointer place(pointer);
  return json.contains(place) ? &json[place] : nullptr;
}

/// Links resolved as far as there is something: ".." of a link is not the folder that it lies in.
fs::path resolved(const fs::path& path) {
  std::error_code error;
  fs::path real = fs::weakly_canonical(path, error);
  return error ? path.lexically_normal() : real;
}

fs::path as_seen_from(const fs::path& folder, const fs::path& file) {
  const fs::path there = resolved(file), here = resolved(fs::absolute(folder));
  auto of_file = there.begin(), of_folder = here.begin();
  std::size_t common = 0;
  while (of_file != there.end() && of_folder != here.end() && *of_file == *of_folder)
    ++of_file, ++of_folder, ++common;
  constexpr std::size_t kRootAlone = 1;
  const fs::path relative = there.lexically_relative(here);
  return common > kRootAlone && is_utf8(relative.string()) ? relative : file;
}

/// Empty for what cannot be read, and for devices, which may have no end: the plugin that wants the
/// file says what is wrong with it, and where.
std::string hash_of(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return "";
  try {
    return sha256_of_file(path);
  } catch (const Error&) {
    return "";
  }
}

}  // namespace

std::vector<HashedFile> hashed_files(const Scene& scene) {
  std::vector<HashedFile> hashed;
  for (const SceneFile& file : scene.files)
    hashed.push_back({file.pointer, file.path, hash_of(file.path)});
  return hashed;
}

Json json_of(const std::vector<HashedFile>& files) {
  Json list = Json::array();
  for (const HashedFile& file : files)
    list.push_back(
        {{"pointer", file.pointer}, {"file", file.path.string()}, {"sha256", file.sha256}});
  return list;
}

std::string changed_file(const Json& manifest, const std::vector<HashedFile>& files) {
  const Json listed = manifest.value("files", Json::array());
  for (const HashedFile& file : files) {
    bool is_the_same = false;
    for (const Json& then : listed) {
      if (!then.is_object() || then.value("pointer", Json()) != file.pointer) continue;
      is_the_same = then.value("sha256", Json()) == file.sha256;
    }
    if (!is_the_same)
      return fmt::format("{}, which the scene names at {}, does not hold what it held then",
                         file.path.string(), file.pointer);
  }
  return "";
}

std::string scene_text(const std::string& completed, const std::vector<SceneFile>& files,
                       const fs::path& folder) {
  if (files.empty()) return completed;
  Json json = Json::parse(completed);
  for (const SceneFile& file : files) {
    if (Json* path = member_at(json, file.pointer))
      *path = as_seen_from(folder, file.path).string();
  }
  return json.dump(2) + '\n';
}

std::string scene_text(const Scene& scene, const fs::path& folder) {
  return scene_text(scene.completed, scene.files, folder);
}

std::string identity_of(const std::string& completed, const std::vector<HashedFile>& files) {
  const Json parsed = parse_json(completed);
  if (!parsed.is_object()) return "";
  // Not the ordered kind: how the author laid the scene out makes no difference.
  nlohmann::json json = parsed;
  for (const char* key : {"duration", "checkpoint"}) json.erase(key);
  for (const HashedFile& file : files) {
    if (nlohmann::json* path = member_at(json, file.pointer)) *path = file.sha256;
  }
  return sha256_of(json.dump());
}

}  // namespace deform
