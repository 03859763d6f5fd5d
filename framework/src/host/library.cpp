#include "host/library.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include <boost/dll/shared_library.hpp>

#include "deform/error.h"

#include "host/elf_check.h"
#include "host/guarded_parts.h"
#include "host/interface_check.h"
#include "plugin/boundary.h"
#include "plugin/plugin_call.h"

namespace deform {
namespace {

namespace dll = boost::dll;

std::string in_quotes(std::string_view text) { return '"' + std::string(text) + '"'; }

[[noreturn]] void reject(const std::filesystem::path& path, const std::string& why) {
  throw InputError(path.string() + ": " + why);
}

/// There is no hot reload: what was loaded stays until the process ends. An exception of a class of
/// a plugin's own may be destroyed after everything else that kept its library.
void keep_until_exit(const std::shared_ptr<dll::shared_library>& library) {
  static std::mutex mutex;
  static auto& kept = *new std::vector<std::shared_ptr<dll::shared_library>>;
  const std::lock_guard lock(mutex);
  kept.push_back(library);
}

std::shared_ptr<dll::shared_library> open_library(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) reject(path, "there is no such file");
  if (const std::string why = elf_objection(path); !why.empty()) {
    reject(path, "cannot be loaded: it " + why);
  }
  try {
    const std::string who = path.string();
    const PluginCall call(who, "being loaded");
    auto library = std::make_shared<dll::shared_library>(path, dll::load_mode::rtld_now);
    keep_until_exit(library);
    return library;
  } catch (...) {
    reject(path, "cannot be loaded: " + cause_of_current_exception());
  }
}

/// Differences between a plugin's tag and this host's, in words.
class AbiComparison {
 public:
  void number(const char* what, std::uint32_t found, std::uint32_t expected) {
    if (found != expected) note(what, std::to_string(found), std::to_string(expected));
  }
  void text(const char* what, const char (&found)[32], const char (&expected)[32]) {
    const std::string_view a(found, strnlen(found, sizeof found));
    const std::string_view b(expected, strnlen(expected, sizeof expected));
    if (a != b) note(what, in_quotes(a), in_quotes(b));
  }
  [[nodiscard]] const std::string& differences() const { return differences_; }

 private:
  void note(const std::string& what, const std::string& found, const std::string& expected) {
    if (!differences_.empty()) differences_ += "; ";
    differences_ += what + " is " + found + ", expected " + expected;
  }
  std::string differences_;
};

/// A tag of another size or API number has perhaps another layout: its rest is not read.
std::string abi_differences(const AbiTag& found) {
  const AbiTag expected = abi_tag();
  AbiComparison compare;
  compare.number("size of the ABI tag", found.size, expected.size);
  if (!compare.differences().empty()) return compare.differences();
  compare.number("plugin API number", found.api, expected.api);
  if (!compare.differences().empty()) return compare.differences();
  compare.text("compiler", found.compiler, expected.compiler);
  compare.text("standard library", found.standard_library, expected.standard_library);
  compare.text("build flavour", found.flavour, expected.flavour);
  compare.number("Eigen version", found.eigen, expected.eigen);
  compare.number("EIGEN_MAX_ALIGN_BYTES", found.eigen_max_align, expected.eigen_max_align);
  return compare.differences();
}

void check_name(const PluginFile& file, const PluginDescriptor& descriptor) {
  if (static_cast<std::size_t>(descriptor.kind) >= kPluginKinds.size()) {
    reject(file.path, "the plugin's kind is not one that this program knows");
  }
  const std::string_view kind = name_of(descriptor.kind);
  const std::string name = descriptor.text.name == nullptr ? "" : descriptor.text.name;
  if (descriptor.kind != file.kind || name != file.name) {
    reject(file.path, "the plugin calls itself " + std::string(kind) + "/" + name +
                          ", so its file must be named " + std::string(kind) + "-" + name + ".so");
  }
}

void check_fields(const LoadedPlugin& plugin) {
  std::set<std::string> taken{"plugin"};
  for (const ParameterField& field : common_fields(plugin.file().kind)) taken.insert(field.name);
  for (const ParameterField& field : plugin.fields()) {
    if (!taken.insert(field.name).second) {
      reject(plugin.file().path, "declares the parameter " + in_quotes(field.name) +
                                     ", a name that is reserved or declared twice");
    }
  }
}

}  // namespace

bool is_plugin_name(std::string_view name) {
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  return !name.empty() && is_letter(name.front()) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

std::optional<PluginFile> plugin_file(const std::filesystem::path& path) {
  const std::string stem = path.stem().string();
  const std::size_t dash = stem.find('-');
  if (path.extension() != ".so" || dash == std::string::npos) return std::nullopt;
  const std::optional<PluginKind> kind = kind_named(stem.substr(0, dash));
  const std::string name = stem.substr(dash + 1);
  if (!kind || !is_plugin_name(name)) return std::nullopt;
  return PluginFile{*kind, name, path};
}

LoadedPlugin::LoadedPlugin(PluginFile file, std::shared_ptr<void> library,
                           const PluginDescriptor& descriptor)
    : file_(std::move(file)), library_(std::move(library)), descriptor_(&descriptor) {
  const std::string who = origin();
  const PluginCall call(who, "declaring its parameters");
  descriptor.declare(fields_);
}

std::string LoadedPlugin::origin() const {
  return std::string(name_of(file_.kind)) + "/" + file_.name + " (" + file_.path.string() + ")";
}

std::shared_ptr<Plugin> LoadedPlugin::create(const ParameterValues& values,
                                             const Setup& setup) const {
  std::unique_ptr<Plugin> object;
  const std::string who = origin();
  const PluginCall call(who, "being made");
  try {
    object = descriptor_->create(values, setup);
  } catch (const InputError& error) {
    throw InputError(error.problems());  // A copy: the plugin may have thrown a class of its own.
  } catch (const PluginFailure& failure) {
    if (names_a_plugin(failure))
      throw PluginFailure(failure.what());  // one that this one asked for
    throw PluginFailure(who + " could not be made: " + failure.what());
  } catch (...) {
    throw PluginFailure(who + " could not be made: " + cause_of_current_exception());
  }
  // Not shared by make_shared: the object's memory, and the code that frees it, are the library's,
  // which the deleter keeps loaded.
  std::shared_ptr<Plugin> shared(object.release(), [library = library_, who](Plugin* plugin) {
    const PluginCall last(who, "being destroyed");
    delete plugin;
  });
  return through_interface(std::move(shared), file_.kind, who);
}

LoadedPlugin load_plugin(const std::filesystem::path& library) {
  const auto path = std::filesystem::absolute(library).lexically_normal();
  const auto file = plugin_file(path);
  if (!file) reject(path, "a plugin's file must be named KIND-NAME.so");
  const auto opened = open_library(path);
  if (!opened->has(kDescriptorSymbol)) {
    reject(path, "is no plugin: it has no symbol " + std::string(kDescriptorSymbol));
  }
  const auto& descriptor = opened->get<const PluginDescriptor>(kDescriptorSymbol);
  if (const auto differences = abi_differences(descriptor.abi); !differences.empty()) {
    reject(path, "does not fit this program: " + differences + "; build it again");
  }
  check_name(*file, descriptor);
  try {
    LoadedPlugin plugin(*file, opened, descriptor);
    check_fields(plugin);
    return plugin;
  } catch (const InputError&) {
    throw;
  } catch (...) {
    reject(path, "cannot declare its parameters: " + cause_of_current_exception());
  }
}

}  // namespace deform
