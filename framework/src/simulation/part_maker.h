/// Makes the plugin objects that a scene names.
#pragma once

#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/plugin/registry.h"
#include "deform/plugin/setup.h"
#include "deform/simulation/scene.h"
#include "deform/solve/system.h"

namespace deform {

/// Makes plugin objects one by one and collects what is wrong with any of them, so that a user sees
/// all of it at once.
class PartMaker {
 public:
  PartMaker(const Scene& scene, std::shared_ptr<const PluginRegistry> registry);

  /// What constructors look at before there is a surface, and after.
  [[nodiscard]] Setup setup() const;
  [[nodiscard]] Setup setup(const Surface& surface, const NodeVectors& rest,
                            const NodeValues& areas) const;

  /// Nothing when the plugin rejects what the scene says of it: see problems(). Names are unique
  /// within a kind: "bending", "bending_2".
  template <class Interface>
  [[nodiscard]] std::optional<Named<Interface>> make(const PluginUse& use, const Setup& setup);
  /// Those that could be made, in the order given.
  template <class Interface>
  [[nodiscard]] std::vector<Named<Interface>> make_all(const std::vector<PluginUse>& uses,
                                                       const Setup& setup);

  [[nodiscard]] const std::vector<Problem>& problems() const { return problems_; }
  void add(const std::vector<Problem>& problems);
  /// Throws InputError with all problems, each with its place in the scene, when there are any.
  void throw_problems() const;

 private:
  [[nodiscard]] std::string unique_name(PluginKind kind, const std::string& name);

  const Scene& scene_;
  std::shared_ptr<const PluginRegistry> registry_;
  std::map<PluginKind, std::set<std::string>> names_;
  std::vector<Problem> problems_;
};

template <class Interface>
std::optional<Named<Interface>> PartMaker::make(const PluginUse& use, const Setup& setup) {
  try {
    auto object = std::dynamic_pointer_cast<Interface>(registry_->create(use, setup));
    const std::string origin = registry_->load(use.kind, use.name).origin();
    if (!object) {
      throw PluginFailure(fmt::format("{} made an object of another kind", origin));
    }
    return Named<Interface>{unique_name(use.kind, use.name), origin, std::move(object)};
  } catch (const InputError& e) {
    add(e.problems());
    return std::nullopt;
  }
}

template <class Interface>
std::vector<Named<Interface>> PartMaker::make_all(const std::vector<PluginUse>& uses,
                                                  const Setup& setup) {
  std::vector<Named<Interface>> made;
  for (const PluginUse& use : uses) {
    if (auto part = make<Interface>(use, setup)) made.push_back(std::move(*part));
  }
  return made;
}

}  // namespace deform
