#include "compare/run_names.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "json/json.h"
#include "json/json_pointer.h"

namespace deform {
namespace {

/// Longer ones are cut.
constexpr std::size_t kLongestValue = 32;

/// What may stand in a run's name; anything else becomes one underscore.
std::string sanitised(const std::string& text) {
  std::string clean;
  for (const char c : text) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (letter || std::string_view("-+=.").find(c) != std::string_view::npos) {
      clean += c;
    } else if (!clean.empty() && clean.back() != '_') {
      clean += '_';
    }
  }
  while (!clean.empty() && clean.back() == '_') clean.pop_back();
  return clean.substr(0, kLongestValue);
}

/// "gauss" for {"plugin": "gauss", "delta": 0.5}: the parameters tell it from others where needed.
std::string label_of(const std::string& value) {
  const Json json = Json::parse(value, nullptr, false);
  if (!json.is_object() || !json.contains("plugin") || !json["plugin"].is_string())
    return sanitised(value);
  std::string label = json["plugin"].get<std::string>();
  for (const auto& [key, parameter] : json.items())
    if (key != "plugin") label += "_" + key + "=" + parameter.dump();
  return sanitised(label);
}

/// The last `count` keys of a pointer that mean something to a reader.
std::string tail_of(const std::string& pointer, std::size_t count) {
  auto steps = pointer_steps(pointer).value_or(std::vector<std::string>{pointer});
  if (steps.size() > 1 && steps.back() == "plugin") steps.pop_back();
  std::string tail;
  for (std::size_t i = steps.size() - std::min(count, steps.size()); i < steps.size(); ++i)
    tail += fmt::format("{}{}", tail.empty() ? "" : ".", sanitised(steps[i]));
  return tail;
}

std::vector<std::string> keys_of(const std::vector<Variation>& variations) {
  std::vector<std::string> keys;
  for (std::size_t count = 1; count <= 32; ++count) {
    keys.clear();
    for (const Variation& variation : variations) {
      const std::string key = tail_of(variation.pointer, count);
      // A number alone, as the last step of /energies/1 is, says nothing.
      const bool number = key.find_first_not_of("0123456789") == std::string::npos;
      keys.push_back(number ? tail_of(variation.pointer, count + 1) : key);
    }
    if (std::set<std::string>(keys.begin(), keys.end()).size() == keys.size()) return keys;
  }
  return keys;
}

}  // namespace

std::vector<std::vector<std::string>> value_labels(const std::vector<Variation>& variations) {
  const std::vector<std::string> keys = keys_of(variations);
  std::vector<std::vector<std::string>> labels;
  for (std::size_t v = 0; v < variations.size(); ++v) {
    std::set<std::string> taken;
    std::vector<std::string>& own = labels.emplace_back();
    for (const std::string& value : variations[v].values) {
      const std::string label = fmt::format("{}={}", keys[v], label_of(value));
      std::string unique = label;
      for (int number = 2; !taken.insert(unique).second; ++number)
        unique = fmt::format("{}-{}", label, number);
      own.push_back(unique);
    }
  }
  return labels;
}

}  // namespace deform
