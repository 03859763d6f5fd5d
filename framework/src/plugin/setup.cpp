#include "deform/plugin/setup.h"

#include "deform/surface/surface.h"

namespace deform {

NodeValues areas_of_mass(const Surface& surface, const Material& material) {
  return material.mass == AreaOf::parameters ? surface.areas() : surface.rest_areas();
}

const Surface& Setup::surface() const {
  if (surface_ == nullptr) {
    throw Error(ExitCode::plugin_failed, "there is no surface yet when this plugin is made");
  }
  return *surface_;
}

const NodeVectors& Setup::rest() const {
  if (rest_ == nullptr) {
    throw Error(ExitCode::plugin_failed, "there is no rest state yet when this plugin is made");
  }
  return *rest_;
}

const NodeValues& Setup::areas() const {
  if (areas_ == nullptr) {
    throw Error(ExitCode::plugin_failed, "there is no surface yet when this plugin is made");
  }
  return *areas_;
}

std::filesystem::path Setup::resolve(const std::filesystem::path& file) const {
  return (folder_ / file).lexically_normal();  // An absolute file replaces the folder.
}

std::vector<Index> Setup::select(const NodeSelection& where) const {
  return select_nodes(surface(), where);
}

std::shared_ptr<Plugin> Setup::create_any(const PluginUse& use) const {
  if (!factory_) throw Error(ExitCode::plugin_failed, "this plugin cannot make other plugins here");
  if (use.name.empty()) {
    throw InputError({{use.pointer, "a " + std::string(name_of(use.kind)) + " plugin is missing"}});
  }
  return factory_(use, *this);
}

Setup& Setup::with_surface(const Surface& surface, const NodeVectors& rest,
                           const NodeValues& areas) {
  surface_ = &surface;
  rest_ = &rest;
  areas_ = &areas;
  return *this;
}

Setup& Setup::with_material(const Material& material) {
  material_ = material;
  return *this;
}

Setup& Setup::with_folder(std::filesystem::path folder) {
  folder_ = std::move(folder);
  return *this;
}

}  // namespace deform
