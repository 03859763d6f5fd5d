#include "host/elf_check.h"

#include <cstring>
#include <elf.h>
#include <fstream>
#include <link.h>
#include <vector>

namespace deform {
namespace {

using Header = ElfW(Ehdr);
using Segment = ElfW(Phdr);

template <class T>
bool read_at(std::ifstream& file, std::uint64_t offset, T* to, std::size_t count = 1) {
  file.seekg(static_cast<std::streamoff>(offset));
  file.read(reinterpret_cast<char*>(to), static_cast<std::streamsize>(count * sizeof(T)));
  return file.good();
}

/// What an ELF file for this machine says here, the program's own library among them.
bool is_of_this_machine(const Header& header) {
#if defined(__x86_64__)
  constexpr int machine = EM_X86_64;
#elif defined(__aarch64__)
  constexpr int machine = EM_AARCH64;
#else
  const int machine = header.e_machine;  // left to the loader
#endif
  constexpr int word = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;
  return header.e_ident[EI_CLASS] == word && header.e_machine == machine;
}

}  // namespace

std::string elf_objection(const std::filesystem::path& path) {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) return "cannot be read";
  Header header{};
  const bool is_elf =
      read_at(file, 0, &header) && std::memcmp(header.e_ident, ELFMAG, SELFMAG) == 0;
  if (!is_elf) return "is no shared library: it does not begin with an ELF header";
  if (!is_of_this_machine(header)) return "is a library for another machine";
  if (header.e_type != ET_DYN) return "is no shared library, but an ELF file of another kind";

  std::string cut_off = "is cut off: its header tells of more than the " + std::to_string(size) +
                        " bytes that there are";
  std::vector<Segment> segments(header.e_phnum);
  if (header.e_phentsize != sizeof(Segment) ||
      !read_at(file, header.e_phoff, segments.data(), segments.size()))
    return cut_off;
  for (const Segment& segment : segments) {
    const bool fits = segment.p_offset <= size && segment.p_filesz <= size - segment.p_offset;
    if (segment.p_type == PT_LOAD && !fits) return cut_off;
  }
  return "";
}

}  // namespace deform
