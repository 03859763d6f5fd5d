#pragma once

#include <chrono>
#include <filesystem>
#include <string>

namespace deform {

/// The browser: $DEFORM_CHROMIUM, else the first of the usual names on the PATH; empty when there
/// is none.
[[nodiscard]] std::filesystem::path find_chromium();

/// Opens an address without a window and returns the document as it is once nothing happens any
/// more, or as it is after `patience`. Throws Error when the browser fails, naming it and what it
/// said.
[[nodiscard]] std::string document_of(const std::filesystem::path& chromium,
                                      const std::string& address, std::chrono::seconds patience);

}  // namespace deform
