#include "simulation/machine.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <link.h>
#include <set>
#include <system_error>
#include <unistd.h>

#include <Eigen/Core>
#include <boost/dll/runtime_symbol_info.hpp>
#include <boost/version.hpp>
#include <fmt/format.h>
#include <openssl/opensslv.h>
#include <spdlog/version.h>
#include <tbb/version.h>

#include "files/sha256.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

/// "libcholmod.so.4.0.3"; not "energy-bending.so", nor "ld-linux-x86-64.so.2".
bool is_library(const fs::path& file) {
  const std::string name = file.filename().string();
  constexpr std::array kSystem{"libc.", "libm.", "libdl.", "libpthread.", "librt.", "libgcc_s."};
  return name.starts_with("lib") && name.find(".so") != std::string::npos &&
         std::ranges::none_of(kSystem,
                              [&](const char* prefix) { return name.starts_with(prefix); });
}

}  // namespace

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

std::string cpu_model() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "";
}

Json built_with() {
  return {{"compiler", fmt::format("{} {}",
#if defined(__clang__)
                                   "clang++",
#else
                                   "g++",
#endif
                                   __VERSION__)},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"tbb", fmt::format("{}.{}.{}", TBB_VERSION_MAJOR, TBB_VERSION_MINOR, TBB_VERSION_PATCH)},
          {"boost", fmt::format("{}.{}.{}", BOOST_VERSION / 100000, BOOST_VERSION / 100 % 1000,
                                BOOST_VERSION % 100)},
          {"fmt", fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100,
                              FMT_VERSION % 100)},
          {"spdlog", fmt::format("{}.{}.{}", SPDLOG_VER_MAJOR, SPDLOG_VER_MINOR, SPDLOG_VER_PATCH)},
          {"json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                               NLOHMANN_JSON_VERSION_PATCH)},
          {"openssl", OPENSSL_VERSION_TEXT}};
}

Json loaded_libraries() {
  std::set<std::string> found;
  const auto add = [](dl_phdr_info* info, std::size_t /*size*/, void* to) {
    std::error_code error;
    const fs::path file = fs::canonical(info->dlpi_name, error);
    if (!error && is_library(file)) static_cast<std::set<std::string>*>(to)->insert(file.string());
    return 0;
  };
  ::dl_iterate_phdr(add, &found);
  return found;
}

Json own_library() {
  static const Json library = [] {
    std::error_code error;
    const fs::path file = boost::dll::this_line_location(error);
    return Json{{"file", file.string()}, {"sha256", sha256_of_file(file)}};
  }();
  return library;
}

}  // namespace deform
