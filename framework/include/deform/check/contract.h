/// Tests what a plugin of each kind promises, on a few small surfaces: `deform plugin check`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "deform/export.h"

namespace deform {

enum class CheckOutcome : std::uint8_t {
  passed,
  failed,
  reported,  ///< a figure that no promise bounds
};

/// One thing that was looked at, over all surfaces and states; its figure is the worst of them.
struct CheckLine {
  std::string name;
  std::string figure;  ///< empty where there is none
  std::string limit;   ///< that the figure must not pass; empty where there is none
  CheckOutcome outcome = CheckOutcome::passed;
  std::string note;  ///< where the figure is worst, or what went wrong
};

struct ContractReport {
  std::string plugin;  ///< kind/name and file
  std::vector<CheckLine> lines;
  [[nodiscard]] DEFORM_API bool passed() const;
};

struct ContractOptions {
  std::filesystem::path library;
  /// Searched before the installation, for what the plugin names.
  std::vector<std::filesystem::path> folders;
  /// JSON object of the parameters that a scene would give; those that are required must be there.
  std::string parameters = "{}";
};

/// Throws InputError when the library does not load or rejects its parameters.
[[nodiscard]] DEFORM_API ContractReport check_contract(const ContractOptions& options);

}  // namespace deform
