#include "simulation/part_maker.h"

#include <utility>

#include <fmt/format.h>

namespace deform {

PartMaker::PartMaker(const Scene& scene, std::shared_ptr<const PluginRegistry> registry)
    : scene_(scene), registry_(std::move(registry)) {}

Setup PartMaker::setup() const {
  Setup setup([registry = registry_](const PluginUse& use, const Setup& inner) {
    return registry->create(use, inner);
  });
  setup.with_material(scene_.material)
      .with_folder(std::filesystem::absolute(scene_.file).parent_path());
  return setup;
}

Setup PartMaker::setup(const Surface& surface, const NodeVectors& rest,
                       const NodeValues& areas) const {
  Setup complete = setup();
  complete.with_surface(surface, rest, areas);
  return complete;
}

void PartMaker::add(const std::vector<Problem>& problems) {
  problems_.insert(problems_.end(), problems.begin(), problems.end());
}

void PartMaker::throw_problems() const {
  if (problems_.empty()) return;
  std::vector<Problem> placed;
  for (const Problem& problem : problems_) placed.push_back(scene_.located(problem));
  throw InputError(std::move(placed));
}

std::optional<Named<Plugin>> PartMaker::make_any(const PluginUse& use, const Setup& setup) {
  try {
    auto object = registry_->create(use, setup);
    Named<Plugin> part{unique_name(use.kind, use.name),
                       registry_->load(use.kind, use.name).origin(), std::move(object)};
    made_.push_back({fmt::format("{}/{}", name_of(use.kind), part.name), part.origin, part.object});
    return part;
  } catch (const InputError& e) {
    add(e.problems());
    return std::nullopt;
  }
}

void PartMaker::try_all(PluginKind kind, const Setup& setup) {
  for (const PluginUse& use : scene_.plugins[kind]) (void)make_any(use, setup);
}

std::string PartMaker::unique_name(PluginKind kind, const std::string& name) {
  std::set<std::string>& taken = names_[kind];
  std::string unique = name;
  for (int number = 2; !taken.insert(unique).second; ++number) {
    unique = fmt::format("{}_{}", name, number);
  }
  return unique;
}

}  // namespace deform
