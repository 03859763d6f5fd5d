#include "report/chromium.h"

#include <cstdlib>
#include <sstream>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

#include <boost/process/args.hpp>
#include <boost/process/child.hpp>
#include <boost/process/exe.hpp>
#include <boost/process/group.hpp>
#include <boost/process/io.hpp>
#include <fmt/format.h>

#include "deform/error.h"

#include "files/files.h"

namespace deform {
namespace {

namespace bp = boost::process;
namespace fs = std::filesystem;

/// Of what a browser says, which is much even if all is well: the end, where the reason stands.
constexpr std::size_t kMostSaid = 600;

/// A folder for what a browser keeps, so that it leaves the user's own alone; goes with its owner.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "deform-chromium-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw Error(ExitCode::internal_error, fmt::format("cannot make a folder {}", name));
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;  // processes of the browser may still write there
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::vector<std::string> arguments(const fs::path& profile, const std::string& address,
                                   std::chrono::seconds patience) {
  std::vector<std::string> arguments{
      "--headless",
      "--dump-dom",
      // Drawn by the processor, alike everywhere: machines that simulate rarely have a display.
      "--use-gl=angle",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--ignore-gpu-blocklist",
      "--disable-background-networking",
      "--no-first-run",
      "--window-size=1400,900",
      // Time passes as fast as the page allows, so that a large one is not cut short.
      fmt::format("--virtual-time-budget={}",
                  std::chrono::duration_cast<std::chrono::milliseconds>(patience).count()),
      "--user-data-dir=" + profile.string(),
  };
  // Its sandbox refuses to serve the administrator.
  if (::geteuid() == 0) arguments.emplace_back("--no-sandbox");
  arguments.push_back(address);
  return arguments;
}

/// The program of that name that a shell would start; empty when there is none. (Boost's own search
/// needs a library of Boost's.)
fs::path on_path(const char* name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    fs::path program = fs::path(folder) / name;
    if (!folder.empty() && ::access(program.c_str(), X_OK) == 0) return program;
  }
  return {};
}

std::string end_of(const std::string& text) {
  return text.size() > kMostSaid ? "…" + text.substr(text.size() - kMostSaid) : text;
}

/// Waits for a process and all that it started; false, and they are gone, when time is up.
bool wait(bp::child& process, bp::group& group, std::chrono::seconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  std::error_code error;
  while (process.running(error)) {
    if (std::chrono::steady_clock::now() > end) {
      group.terminate(error);
      process.wait(error);
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

}  // namespace

fs::path find_chromium() {
  if (const char* const given = std::getenv("DEFORM_CHROMIUM"); given != nullptr && *given != '\0')
    return given;
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    if (fs::path found = on_path(name); !found.empty()) return found;
  }
  return {};
}

std::string document_of(const fs::path& chromium, const std::string& address,
                        std::chrono::seconds patience) {
  const TemporaryFolder folder;
  const fs::path document = folder.path() / "document.html", said = folder.path() / "said.txt";
  std::error_code error;
  bp::group group;
  bp::child process(bp::exe = chromium.string(),
                    bp::args = arguments(folder.path() / "profile", address, patience),
                    (bp::std_in < bp::null), (bp::std_out > document.string()),
                    (bp::std_err > said.string()), group, error);
  const auto fail = [&chromium](const std::string& why) {
    return Error(ExitCode::internal_error, fmt::format("{}: {}", chromium.string(), why));
  };
  if (error) throw fail("cannot be started: " + error.message());
  if (!wait(process, group, patience))
    throw fail(fmt::format("did not come to an end within {} s", patience.count()));
  if (process.exit_code() != 0) {
    throw fail(fmt::format("ended with {}: {}", process.exit_code(),
                           end_of(read_file(said).value_or(""))));
  }
  return read_file(document).value_or("");
}

}  // namespace deform
