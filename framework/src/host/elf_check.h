#pragma once

#include <filesystem>
#include <string>

namespace deform {

/// Why a file cannot be a whole shared library for this machine; empty if it may be one. The
/// system's loader trusts what a file's header says: one that was cut off would end the program
/// with a bus error.
std::string elf_objection(const std::filesystem::path& file);

}  // namespace deform
