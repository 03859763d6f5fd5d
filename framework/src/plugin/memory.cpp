#include <limits>
#include <utility>

#include "deform/error.h"
#include "deform/plugin/plugin.h"

namespace deform {

void Memory::put(const std::string& name, std::vector<double> values) {
  entries_[name] = std::move(values);
}

const std::vector<double>& Memory::get(const std::string& name, std::size_t size) const {
  const auto entry = entries_.find(name);
  if (entry == entries_.end()) throw InputError("the checkpoint has no \"" + name + "\"");
  if (entry->second.size() != size) {
    throw InputError("the checkpoint's \"" + name + "\" has " +
                     std::to_string(entry->second.size()) + " numbers, expected " +
                     std::to_string(size));
  }
  return entry->second;
}

Plugin::~Plugin() = default;
void Plugin::save(Memory& /*memory*/) const {}
void Plugin::load(const Memory& /*memory*/) {}
double Plugin::longest_step(double /*time*/) const {
  return std::numeric_limits<double>::infinity();
}
double Plugin::next_break(double /*after*/) const {
  return std::numeric_limits<double>::infinity();
}

}  // namespace deform
