/// The base of everything that a plugin library makes.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "deform/export.h"

namespace deform {

/// What an object remembers between steps, by name; goes into checkpoints.
class DEFORM_API Memory {
 public:
  void put(const std::string& name, std::vector<double> values);
  /// Throws InputError when the name is missing or its length is not `size`.
  [[nodiscard]] const std::vector<double>& get(const std::string& name, std::size_t size) const;
  [[nodiscard]] const std::map<std::string, std::vector<double>>& entries() const {
    return entries_;
  }

 private:
  std::map<std::string, std::vector<double>> entries_;
};

/// Base of every plugin interface. Objects without memory need neither save nor load.
class DEFORM_API Plugin {
 public:
  Plugin() = default;
  Plugin(const Plugin&) = delete;
  Plugin& operator=(const Plugin&) = delete;
  virtual ~Plugin();

  virtual void save(Memory& memory) const;
  virtual void load(const Memory& memory);
};

}  // namespace deform
