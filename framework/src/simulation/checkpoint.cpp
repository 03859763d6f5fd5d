#include "simulation/checkpoint.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deform/error.h"

#include "files/sha256.h"

namespace deform {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they are");

constexpr std::string_view kMagic = "deform checkpoint\n";
constexpr std::uint32_t kVersion = 3;
constexpr std::size_t kHashDigits = 64;
/// What every checkpoint has: its head, without entries, and the checksum.
constexpr std::size_t kLeast = kMagic.size() + 4 + kHashDigits + 3 * 8 + kHashDigits;

template <class Number>
void put(std::string& out, Number number) {
  static_assert(std::is_arithmetic_v<Number>);
  char bytes[sizeof(Number)];
  std::memcpy(bytes, &number, sizeof(Number));
  out.append(bytes, sizeof(Number));
}

/// Takes a content apart from its beginning; believes no length before it was compared with what
/// is there.
class Reader {
 public:
  Reader(std::string_view content, const std::string& file) : rest_(content), file_(file) {}

  [[noreturn]] void refuse(const std::string& reason) const {
    throw InputError(fmt::format("cannot resume from {}: {}", file_, reason));
  }
  void require(bool condition, const char* reason) const {
    if (!condition) refuse(reason);
  }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

  std::string_view bytes(std::uint64_t count) {
    require(count <= rest_.size(), kOverrun);
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  template <class Number>
  Number number() {
    Number number;
    std::memcpy(&number, bytes(sizeof(Number)).data(), sizeof(Number));
    return number;
  }
  std::vector<double> doubles(std::uint64_t count) {
    require(count <= rest_.size() / sizeof(double), kOverrun);
    std::vector<double> values(count);
    const std::string_view taken = bytes(count * sizeof(double));
    if (count > 0) std::memcpy(values.data(), taken.data(), taken.size());
    return values;
  }

 private:
  static constexpr const char* kOverrun = "a length in it goes beyond its end";
  std::string_view rest_;
  const std::string& file_;
};

/// Takes head and checksum off: what is left are the entries.
void check_seal(Reader& reader, std::string_view content) {
  const std::string_view start = content.substr(0, kMagic.size());
  reader.require(start == kMagic, "it is not a checkpoint of deform");
  reader.require(content.size() >= kMagic.size() + 4, "it is cut short");
  (void)reader.bytes(kMagic.size());
  const auto version = reader.number<std::uint32_t>();
  if (version != kVersion) {
    reader.refuse(
        fmt::format("its format has version {}, this program reads version {}", version, kVersion));
  }
  reader.require(content.size() >= kLeast, "it is cut short");
  const std::string_view sealed = content.substr(0, content.size() - kHashDigits);
  reader.require(content.substr(sealed.size()) == sha256_of(sealed),
                 "its checksum is wrong; it is damaged or cut short");
}

/// A name that leads out of the run directory is none that a run writes.
bool is_within(const std::string& name) {
  const std::filesystem::path path(name);
  return !name.empty() && path.is_relative() && path == path.lexically_normal() &&
         *path.begin() != "..";
}

std::vector<WrittenFile> read_files(Reader& reader) {
  std::vector<WrittenFile> files;
  const auto count = reader.number<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto name_length = reader.number<std::uint64_t>();
    const auto hash_length = reader.number<std::uint64_t>();
    reader.require(hash_length == 0 || hash_length == kHashDigits, "a hash in it is none");
    WrittenFile& file = files.emplace_back();
    file.bytes = reader.number<std::uint64_t>();
    file.name = reader.bytes(name_length);
    reader.require(is_within(file.name), "a file in it is none of a run directory");
    file.sha256 = reader.bytes(hash_length);
  }
  return files;
}

Memory read_entries(Reader& reader) {
  Memory memory;
  std::string last;
  const auto count = reader.number<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto name_length = reader.number<std::uint64_t>();
    const auto list_length = reader.number<std::uint64_t>();
    std::string name(reader.bytes(name_length));
    reader.require(i == 0 || last < name, "the names in it do not ascend");
    memory.put(name, reader.doubles(list_length));
    last = std::move(name);
  }
  return memory;
}

}  // namespace

const WrittenFile* Checkpoint::file(const std::string& name) const {
  const auto found = std::ranges::find(files, name, &WrittenFile::name);
  return found == files.end() ? nullptr : &*found;
}

std::string sealed(std::string content) {
  content += sha256_of(content);
  return content;
}

std::string encoded(const Checkpoint& checkpoint) {
  std::string out(kMagic);
  put(out, kVersion);
  out += checkpoint.scene;
  put(out, std::int64_t{checkpoint.step});
  put(out, std::uint64_t{checkpoint.files.size()});
  for (const WrittenFile& file : checkpoint.files) {
    put(out, std::uint64_t{file.name.size()});
    put(out, std::uint64_t{file.sha256.size()});
    put(out, file.bytes);
    out += file.name + file.sha256;
  }
  const auto& entries = checkpoint.memory.entries();
  put(out, std::uint64_t{entries.size()});
  for (const auto& [name, values] : entries) {
    put(out, std::uint64_t{name.size()});
    put(out, std::uint64_t{values.size()});
    out += name;
    out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  }
  return sealed(std::move(out));
}

Checkpoint decode_checkpoint(std::string_view content, const std::string& file) {
  Reader head(content, file);
  check_seal(head, content);
  const std::size_t read = content.size() - head.left();
  Reader reader(content.substr(read, content.size() - read - kHashDigits), file);
  Checkpoint checkpoint;
  checkpoint.scene = reader.bytes(kHashDigits);
  checkpoint.step = reader.number<std::int64_t>();
  reader.require(checkpoint.step >= 0, "its number of steps is negative");
  checkpoint.files = read_files(reader);
  checkpoint.memory = read_entries(reader);
  reader.require(reader.left() == 0, "it is longer than what it says it holds");
  return checkpoint;
}

std::filesystem::path checkpoint_file(const std::filesystem::path& folder) {
  return folder / "checkpoint.bin";
}

void write_checkpoint(const std::filesystem::path& folder, const Checkpoint& checkpoint) {
  write_atomically(checkpoint_file(folder), encoded(checkpoint));
}

std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& folder) {
  const std::filesystem::path file = checkpoint_file(folder);
  const std::optional<std::string> content = read_file(file);
  if (!content) return std::nullopt;
  return decode_checkpoint(*content, file.string());
}

CheckpointSchedule::CheckpointSchedule(const Scene& scene)
    : every_(scene.checkpoint_every), seconds_(scene.checkpoint_seconds) {}

bool CheckpointSchedule::due(long step) const {
  if (every_ > 0 && step % every_ == 0) return true;
  return seconds_ > 0 && std::chrono::duration<double>(Clock::now() - last_).count() >= seconds_;
}

}  // namespace deform
