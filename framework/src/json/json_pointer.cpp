#include "json/json_pointer.h"

#include <charconv>

#include "json/shown.h"
#include "text/nearest_name.h"

namespace deform {
namespace {

/// The step to the place behind the last item of an array (RFC 6901).
constexpr std::string_view kBehindLast = "-";

std::string escaped(std::string_view key) {
  std::string step;
  for (const char c : key) {
    if (c == '~') {
      step += "~0";
    } else if (c == '/') {
      step += "~1";
    } else {
      step += c;
    }
  }
  return step;
}

/// The key that a pointer's step stands for; nothing where a ~ is followed by neither 0 nor 1.
std::optional<std::string> unescaped(std::string_view step) {
  std::string key;
  for (std::size_t i = 0; i < step.size(); ++i) {
    if (step[i] != '~') {
      key += step[i];
      continue;
    }
    if (++i == step.size() || (step[i] != '0' && step[i] != '1')) return std::nullopt;
    key += step[i] == '0' ? '~' : '/';
  }
  return key;
}

/// The index that a step stands for; nothing if it is none, or has leading zeros.
std::optional<std::size_t> index_of(const std::string& step) {
  std::size_t index = 0;
  const char* const end = step.data() + step.size();
  const auto [stop, error] = std::from_chars(step.data(), end, index);
  const bool zeros = step.size() > 1 && step.front() == '0';
  if (error != std::errc() || stop != end || zeros) return std::nullopt;
  return index;
}

/// What a step leads to; null where it leads nowhere.
const Json* child(const Json& json, const std::string& step) {
  if (json.is_object()) {
    const auto member = json.find(step);
    return member == json.end() ? nullptr : &*member;
  }
  const auto index = json.is_array() ? index_of(step) : std::nullopt;
  return index && *index < json.size() ? &json[*index] : nullptr;
}

const Json* find(const Json& json, const std::vector<std::string>& steps, std::size_t count) {
  const Json* at = &json;
  for (std::size_t i = 0; i < count && at != nullptr; ++i) at = child(*at, steps[i]);
  return at;
}

std::string no_such(const Json& json, const std::string& pointer, const std::string& step) {
  const std::string place = pointer.empty() ? "the scene" : pointer;
  if (json.is_array()) {
    return place + " has no item " + shown(step) + ", it has " + std::to_string(json.size());
  }
  if (!json.is_object()) return place + " is " + shown(json) + ", which has nothing in it";
  std::vector<std::string> keys;
  for (const auto& member : json.items()) keys.push_back(member.key());
  return place + " has no key " + shown(step) + did_you_mean(step, keys);
}

}  // namespace

std::optional<std::vector<std::string>> pointer_steps(std::string_view pointer) {
  std::vector<std::string> steps;
  while (!pointer.empty()) {
    if (pointer.front() != '/') return std::nullopt;
    pointer.remove_prefix(1);
    const std::size_t end = std::min(pointer.find('/'), pointer.size());
    auto key = unescaped(pointer.substr(0, end));
    if (!key) return std::nullopt;
    steps.push_back(std::move(*key));
    pointer.remove_prefix(end);
  }
  return steps;
}

std::string child_pointer(const std::string& pointer, std::string_view key) {
  return pointer + '/' + escaped(key);
}
std::string child_pointer(const std::string& pointer, std::size_t index) {
  return pointer + '/' + std::to_string(index);
}

std::string parent_pointer(const std::string& pointer) {
  const std::size_t slash = pointer.rfind('/');
  return slash == std::string::npos ? "" : pointer.substr(0, slash);
}

bool is_within(std::string_view pointer, std::string_view ancestor) {
  if (!pointer.starts_with(ancestor)) return false;
  return pointer.size() == ancestor.size() || pointer[ancestor.size()] == '/';
}

std::string replace_at(Json& scene, const std::string& pointer, const Json& value,
                       const std::function<Json()>& completed) {
  const auto steps = pointer_steps(pointer);
  if (!steps || steps->empty()) return "this is no JSON pointer to a value, which begins with /";
  Json* at = &scene;
  std::string path;
  for (std::size_t i = 0; i < steps->size(); ++i) {
    const std::string& step = (*steps)[i];
    if (at->is_string()) {
      const Json full = completed();
      const Json* const written_out = find(full, *steps, i);
      const bool is_use = written_out != nullptr && written_out->is_object();
      if (is_use) *at = Json{{"plugin", at->get<std::string>()}};
    }
    const bool is_last = i + 1 == steps->size();
    if (is_last && at->is_array() && step == kBehindLast) {
      at->push_back(value);
      return "";
    }
    if (child(*at, step) == nullptr) {
      if (!at->is_object()) return no_such(*at, path, step);
      const Json full = is_last ? Json() : completed();
      const Json* const by_default = is_last ? &value : find(full, *steps, i + 1);
      if (by_default == nullptr) return no_such(*at, path, step);
      (*at)[step] = *by_default;
    }
    at = const_cast<Json*>(child(*at, step));
    path = child_pointer(path, step);
  }
  *at = value;
  return "";
}

std::string pointer_of_put(const Json& scene, const std::string& pointer) {
  const auto steps = pointer_steps(pointer);
  if (!steps || steps->empty() || steps->back() != kBehindLast) return pointer;
  const Json* const list = find(scene, *steps, steps->size() - 1);
  const bool is_item = list != nullptr && list->is_array() && !list->empty();
  return is_item ? child_pointer(parent_pointer(pointer), list->size() - 1) : pointer;
}

}  // namespace deform
