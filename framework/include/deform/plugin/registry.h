/// The plugin host: finds libraries, checks them, keeps them loaded, makes objects.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "deform/export.h"
#include "deform/plugin/descriptor.h"

namespace deform {

/// [a-z][a-z0-9_]*
[[nodiscard]] DEFORM_API bool is_plugin_name(std::string_view name);

/// A library found in a search folder; its file name `KIND-NAME.so` says what it holds.
struct PluginFile {
  PluginKind kind;
  std::string name;
  std::filesystem::path path;
};

/// A folder that is searched, and on whose word.
struct SearchFolder {
  std::filesystem::path path;
  std::string said_by;  ///< "--plugin-path", "DEFORM_PLUGIN_PATH", "installation"
};

/// A library that is loaded and fits this host.
class DEFORM_API LoadedPlugin {
 public:
  LoadedPlugin(PluginFile file, std::shared_ptr<void> library, const PluginDescriptor& descriptor);
  [[nodiscard]] const PluginFile& file() const { return file_; }
  [[nodiscard]] const PluginDescriptor& descriptor() const { return *descriptor_; }
  [[nodiscard]] const ParameterFields& fields() const { return fields_; }
  /// "normal/gauss (…/normal-gauss.so)".
  [[nodiscard]] std::string origin() const;
  /// Makes an object of the kind's interface, which keeps the library loaded as long as it lives.
  /// Throws InputError for what the constructor rejects, PluginFailure for whatever else it throws
  /// or when the object has another interface. Nobody else needs to check that.
  [[nodiscard]] std::shared_ptr<Plugin> create(const ParameterValues& values,
                                               const Setup& setup) const;

 private:
  PluginFile file_;
  std::shared_ptr<void> library_;
  const PluginDescriptor* descriptor_;
  ParameterFields fields_;
};

/// Finds plugins by kind and name: in the folders given, then in DEFORM_PLUGIN_PATH (absolute
/// folders which, as all folders above them and the libraries within, belong to root or the user
/// and nobody else may write), then in ../lib/deform/plugins from the program. Never in
/// the current or the scene's folder.
class DEFORM_API PluginRegistry {
 public:
  /// `folders`: from --plugin-path; throws InputError for one that is not a folder. `library`,
  /// where one is given, stands for its kind and name wherever it lies and whatever the folders
  /// hold.
  explicit PluginRegistry(const std::vector<std::filesystem::path>& folders = {},
                          const std::filesystem::path& library = {});
  ~PluginRegistry();
  PluginRegistry(const PluginRegistry&) = delete;
  PluginRegistry& operator=(const PluginRegistry&) = delete;

  [[nodiscard]] const std::vector<SearchFolder>& folders() const;
  /// All libraries found, by kind and name; nothing is loaded for it.
  [[nodiscard]] const std::vector<PluginFile>& files() const;
  /// Names found of a kind, ascending.
  [[nodiscard]] std::vector<std::string> names(PluginKind kind) const;

  /// Loads (once) and checks a library. Throws InputError (without pointer): not found, with every
  /// folder tried and the nearest names; two of one kind and name; not a plugin, or one that does
  /// not fit.
  [[nodiscard]] const LoadedPlugin& load(PluginKind kind, const std::string& name) const;
  /// load() and LoadedPlugin::create(); problems get the use's pointer.
  [[nodiscard]] std::shared_ptr<Plugin> create(const PluginUse& use, const Setup& setup) const;
  /// The same by its kind's interface. Throws InputError for a use of another kind.
  template <class Interface>
  [[nodiscard]] std::shared_ptr<Interface> create(const PluginUse& use, const Setup& setup) const {
    require_kind(use, Interface::kKind);
    return std::static_pointer_cast<Interface>(create(use, setup));
  }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Loads one library by its path, whatever its folder; throws InputError when it is not a plugin
/// that fits.
[[nodiscard]] DEFORM_API LoadedPlugin load_plugin(const std::filesystem::path& library);

/// A parameter in words, for tables and messages: "number", ">= 0", "0.5" (empty where there is
/// none).
struct ParameterText {
  std::string type, range, default_value;
};
[[nodiscard]] DEFORM_API ParameterText describe(const ParameterField& field);

/// The parameters that the framework itself reads for every plugin of a kind: an integrator's
/// `step`, and how often (`every`) a probe or output is due. A plugin must not declare these, nor
/// "plugin".
[[nodiscard]] DEFORM_API const ParameterFields& common_fields(PluginKind kind);

/// JSON Schema (draft 2020-12, as text) of a plugin's object in a scene, from its own
/// and the common fields.
[[nodiscard]] DEFORM_API std::string parameter_schema(const LoadedPlugin& plugin);

}  // namespace deform
