/// What a plugin library exports: one constant-initialised descriptor.
#pragma once

#include <memory>

#include "deform/export.h"
#include "deform/plugin/abi.h"
#include "deform/plugin/declaration.h"
#include "deform/plugin/plugin.h"
#include "deform/plugin/setup.h"

namespace deform {

/// The text that a plugin says of itself (UTF-8).
struct PluginText {
  const char* name = "";  ///< what scenes call it; [a-z][a-z0-9_]*
  const char* version = "";
  const char* summary = "";  ///< one line
  const char* formula = "";
  const char* source = "";  ///< citation
};

struct PluginDescriptor {
  AbiTag abi;  ///< first: checked before anything else is touched
  PluginKind kind;
  PluginText text;
  void (*declare)(ParameterFields& fields);
  std::unique_ptr<Plugin> (*create)(const ParameterValues& values, const Setup& setup);
};

/// Name of the exported symbol; the version in it is that of the descriptor's first bytes.
#define DEFORM_DESCRIPTOR_SYMBOL deform_plugin_descriptor_1
inline constexpr const char* kDescriptorSymbol = "deform_plugin_descriptor_1";

namespace detail {

template <class Parameters>
void declare_fields(ParameterFields& fields) {
  Declaration<Parameters> declaration(fields);
  Parameters::declare(declaration);
}

template <class T, class Parameters>
std::unique_ptr<Plugin> create_plugin(const ParameterValues& values, const Setup& setup) {
  Parameters parameters;
  Declaration<Parameters> declaration(parameters, values);
  Parameters::declare(declaration);
  return std::make_unique<T>(parameters, setup);
}

}  // namespace detail
}  // namespace deform

/// The one export line of a plugin: its class (constructed from (const Parameters&, const Setup&)),
/// its parameters, then a PluginText's designated initialisers:
///
///   DEFORM_PLUGIN(Gauss, Parameters, .name = "gauss", .version = "1.0", .summary = "…")
#define DEFORM_PLUGIN(Class, Parameters, ...)                                      \
  extern "C" DEFORM_API const ::deform::PluginDescriptor DEFORM_DESCRIPTOR_SYMBOL; \
  constinit const ::deform::PluginDescriptor DEFORM_DESCRIPTOR_SYMBOL{             \
      ::deform::abi_tag(), Class::kKind, ::deform::PluginText{__VA_ARGS__},        \
      &::deform::detail::declare_fields<Parameters>,                               \
      &::deform::detail::create_plugin<Class, Parameters>};
