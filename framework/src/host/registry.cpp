#include "deform/plugin/registry.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <mutex>
#include <tuple>
#include <utility>

#include <boost/dll/runtime_symbol_info.hpp>

#include "deform/error.h"

#include "host/library.h"
#include "host/trusted_path.h"
#include "json/shown.h"
#include "text/nearest_name.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOption = "--plugin-path";
constexpr const char* kVariable = "DEFORM_PLUGIN_PATH";
constexpr const char* kInstallation = "installation";

/// Why a folder from DEFORM_PLUGIN_PATH must not be searched; empty if it may. A variable is set
/// once and forgotten, so it must not come to mean another folder, nor one where others put
/// libraries.
std::string objection(const fs::path& folder) {
  std::error_code error;
  if (!folder.is_absolute()) return "is not an absolute path";
  const fs::file_status status = fs::status(folder, error);
  if (!fs::exists(status)) return "does not exist";
  if (!fs::is_directory(status)) return "is not a folder";
  return objection_to(folder);
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    if (end > begin) parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

/// The installation's plugins lie relative to the program; programs that were put elsewhere (tests,
/// other people's) find them beside the framework's library.
fs::path installed_plugins() {
  std::error_code error;
  const fs::path inside = fs::path("deform") / "plugins";
  const fs::path program = boost::dll::program_location(error);
  fs::path by_program = program.parent_path().parent_path() / DEFORM_INSTALL_LIBDIR / inside;
  if (!error && fs::is_directory(by_program, error)) return by_program;
  const fs::path library = boost::dll::this_line_location(error);
  fs::path by_library = library.parent_path() / inside;
  if (!library.empty() && fs::is_directory(by_library, error)) return by_library;
  return by_program;
}

/// The folders to search, each once, in order.
class Folders {
 public:
  void add(const fs::path& path, const std::string& said_by) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(path, error);
    if (std::find(real_.begin(), real_.end(), real) != real_.end()) return;
    real_.push_back(real);
    found_.push_back({fs::absolute(path).lexically_normal(), said_by});
  }
  void reject(const fs::path& path, const std::string& said_by, const std::string& why) {
    problems_.push_back({"", said_by + ": the folder " + path.string() + " " + why});
  }
  [[nodiscard]] std::vector<SearchFolder> take() {
    if (!problems_.empty()) throw InputError(std::move(problems_));
    return std::move(found_);
  }

 private:
  std::vector<SearchFolder> found_;
  std::vector<fs::path> real_;
  std::vector<Problem> problems_;
};

std::vector<SearchFolder> search_folders(const std::vector<fs::path>& given) {
  Folders folders;
  for (const fs::path& path : given) {
    std::error_code error;
    if (fs::is_directory(path, error))
      folders.add(path, kOption);
    else
      folders.reject(path, kOption, fs::exists(path, error) ? "is not a folder" : "does not exist");
  }
  const char* const variable = std::getenv(kVariable);
  for (const std::string& path : split(variable == nullptr ? "" : variable, ':')) {
    const std::string why = objection(path);
    if (why.empty())
      folders.add(path, kVariable);
    else
      folders.reject(path, kVariable, why);
  }
  folders.add(installed_plugins(), kInstallation);
  return folders.take();
}

/// Libraries by kind and name; of one kind and name, in the order of the folders.
std::vector<PluginFile> find_files(const std::vector<SearchFolder>& folders) {
  std::vector<PluginFile> files;
  for (const SearchFolder& folder : folders) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder.path, error)) {
      if (auto file = plugin_file(entry.path())) files.push_back(std::move(*file));
    }
  }
  std::stable_sort(files.begin(), files.end(), [](const PluginFile& a, const PluginFile& b) {
    return std::tie(a.kind, a.name) < std::tie(b.kind, b.name);
  });
  return files;
}

/// One library that stands for its kind and name, whatever else the folders hold.
void prefer(const fs::path& library, std::vector<PluginFile>& files) {
  const auto preferred = plugin_file(fs::absolute(library).lexically_normal());
  if (!preferred) {
    throw InputError(library.string() + ": a plugin's file must be named KIND-NAME.so");
  }
  const auto key = [](const PluginFile& file) { return std::tie(file.kind, file.name); };
  std::erase_if(files, [&](const PluginFile& file) { return key(file) == key(*preferred); });
  const auto at = std::ranges::lower_bound(files, key(*preferred), {}, key);
  files.insert(at, *preferred);
}

/// A problem of a plugin that stands at `pointer` in the scene; problems of a plugin inside of it
/// have their pointer already.
Problem located(Problem problem, const std::string& pointer) {
  if (!problem.pointer.starts_with(pointer)) problem.pointer = pointer + problem.pointer;
  const std::string place = "at " + problem.pointer + ": ";
  const bool placed = problem.pointer.empty() || problem.message.starts_with(place);
  if (!placed) problem.message = place + problem.message;
  return problem;
}

}  // namespace

struct PluginRegistry::Impl {
  std::vector<SearchFolder> folders;
  std::vector<PluginFile> files;
  std::mutex mutex;
  std::map<std::pair<PluginKind, std::string>, LoadedPlugin> loaded;  // Guarded by mutex.

  /// The one library of a kind and name.
  [[nodiscard]] const PluginFile& find(PluginKind kind, const std::string& name) const {
    const auto is_wanted = [&](const PluginFile& f) { return f.kind == kind && f.name == name; };
    const auto first = std::find_if(files.begin(), files.end(), is_wanted);
    if (first == files.end()) throw InputError(not_found(kind, name));
    const auto second = std::next(first);
    if (second != files.end() && is_wanted(*second)) {
      throw InputError("there are two " + std::string(name_of(kind)) + " plugins \"" + name +
                       "\": " + first->path.string() + " and " + second->path.string());
    }
    return *first;
  }

  /// A folder that nobody else writes may hold a library that others do, or a link to one.
  void require_trusted(const PluginFile& file) const {
    const bool is_by_variable = std::ranges::any_of(folders, [&](const SearchFolder& f) {
      return f.said_by == kVariable && f.path / file.path.filename() == file.path;
    });
    const std::string why = is_by_variable ? objection_to(file.path) : "";
    if (!why.empty())
      throw InputError(std::string(kVariable) + ": the library " + file.path.string() + " " + why);
  }

  [[nodiscard]] std::vector<std::string> names(PluginKind kind) const {
    std::vector<std::string> names;
    for (const PluginFile& file : files) {
      const bool is_new = names.empty() || names.back() != file.name;
      if (file.kind == kind && is_new) names.push_back(file.name);
    }
    return names;
  }

  [[nodiscard]] std::string not_found(PluginKind kind, const std::string& name) const {
    std::string message = "there is no " + std::string(name_of(kind)) + " plugin " + shown(name);
    message += did_you_mean(name, names(kind));
    for (const PluginFile& file : files) {
      if (file.name == name) {
        message += "; there is a plugin " + std::string(name_of(file.kind)) + "/" + name;
        break;
      }
    }
    message += "; searched: ";
    for (std::size_t i = 0; i < folders.size(); ++i) {
      message += (i == 0 ? "" : ", ") + folders[i].path.string() + " (" + folders[i].said_by;
      message += fs::is_directory(folders[i].path) ? ")" : ", does not exist)";
    }
    return message;
  }
};

PluginRegistry::PluginRegistry(const std::vector<fs::path>& folders, const fs::path& library)
    : impl_(std::make_unique<Impl>()) {
  impl_->folders = search_folders(folders);
  impl_->files = find_files(impl_->folders);
  if (!library.empty()) prefer(library, impl_->files);
}

PluginRegistry::~PluginRegistry() = default;

const std::vector<SearchFolder>& PluginRegistry::folders() const { return impl_->folders; }
const std::vector<PluginFile>& PluginRegistry::files() const { return impl_->files; }
std::vector<std::string> PluginRegistry::names(PluginKind kind) const { return impl_->names(kind); }

const LoadedPlugin& PluginRegistry::load(PluginKind kind, const std::string& name) const {
  const std::lock_guard lock(impl_->mutex);
  const std::pair key(kind, name);
  auto known = impl_->loaded.find(key);
  if (known == impl_->loaded.end()) {
    const PluginFile& file = impl_->find(kind, name);
    impl_->require_trusted(file);
    known = impl_->loaded.emplace(key, load_plugin(file.path)).first;
  }
  return known->second;
}

std::shared_ptr<Plugin> PluginRegistry::create(const PluginUse& use, const Setup& setup) const {
  static const ParameterValues all_defaults;
  try {
    const LoadedPlugin& plugin = load(use.kind, use.name);
    return plugin.create(use.parameters ? *use.parameters : all_defaults, setup);
  } catch (const InputError& error) {
    std::vector<Problem> problems = error.problems();
    for (Problem& problem : problems) problem = located(std::move(problem), use.pointer);
    throw InputError(std::move(problems));
  }
}

}  // namespace deform
