/// Makes the plugin objects that a scene names.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "deform/error.h"
#include "deform/plugin/registry.h"
#include "deform/plugin/setup.h"
#include "deform/simulation/scene.h"
#include "deform/solve/system.h"

namespace deform {

/// A plugin object as checkpoints know it.
struct MadePart {
  std::string section;  ///< that its memory is kept under: "energy/bending"
  std::string origin;
  std::shared_ptr<Plugin> object;
};

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
  /// All of the kind that the scene names, likewise.
  template <class Interface>
  [[nodiscard]] std::vector<Named<Interface>> make_all(const Setup& setup) {
    return make_all<Interface>(scene_.plugins[Interface::kKind], setup);
  }
  /// Makes all of a kind that the scene names, for the problems that show then.
  void try_all(PluginKind kind, const Setup& setup);

  /// All that could be made so far, in this order.
  [[nodiscard]] const std::vector<MadePart>& made() const { return made_; }
  [[nodiscard]] const std::vector<Problem>& problems() const { return problems_; }
  void add(const std::vector<Problem>& problems);
  /// Throws InputError with all problems, each with its place in the scene, when there are any.
  void throw_problems() const;

 private:
  [[nodiscard]] std::optional<Named<Plugin>> make_any(const PluginUse& use, const Setup& setup);
  [[nodiscard]] std::string unique_name(PluginKind kind, const std::string& name);

  const Scene& scene_;
  std::shared_ptr<const PluginRegistry> registry_;
  PerKind<std::set<std::string>> names_;
  std::vector<MadePart> made_;
  std::vector<Problem> problems_;
};

template <class Interface>
std::optional<Named<Interface>> PartMaker::make(const PluginUse& use, const Setup& setup) {
  require_kind(use, Interface::kKind);
  auto part = make_any(use, setup);
  if (!part) return std::nullopt;
  return Named<Interface>{std::move(part->name), std::move(part->origin),
                          std::static_pointer_cast<Interface>(std::move(part->object))};
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
