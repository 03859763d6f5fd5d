#include "output_file.h"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>
#include <vector>

#include <deform/error.h>

namespace deform::outputs {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) {
  throw Error(ExitCode::internal_error, "cannot write " + path.string() + ": " + reason);
}

/// Of a numbered_name without its extension; −1 of others.
long step_of(const std::string& stem) {
  const std::size_t digits = stem.rfind('_') + 1;  // 0 where there is no number
  long step = -1;
  const auto end = std::from_chars(stem.data() + digits, stem.data() + stem.size(), step);
  return digits > 0 && end.ec == std::errc() && end.ptr == stem.data() + stem.size() ? step : -1;
}

template <class Number>
void append_shortest(std::string& text, Number value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
  text.append(digits, end);
}

}  // namespace

OutputFile::OutputFile(std::filesystem::path path)
    : path_(std::move(path)), temporary_(path_.string() + ".part") {
  // A new file in place of what has its name: where somebody's link leads to is not written to.
  if (::unlink(temporary_.c_str()) != 0 && errno != ENOENT) fail(path_, std::strerror(errno));
  const int made =
      ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  file_ = made < 0 ? nullptr : ::fdopen(made, "wb");
  if (file_ == nullptr) fail(path_, std::strerror(errno));
}

OutputFile::~OutputFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void OutputFile::write(const void* data, std::size_t bytes) {
  if (bytes > 0 && std::fwrite(data, 1, bytes, file_) != bytes) fail(path_, std::strerror(errno));
}

void OutputFile::commit() {
  if (std::fflush(file_) != 0) fail(path_, std::strerror(errno));
  std::FILE* file = file_;
  file_ = nullptr;
  std::error_code error;
  if (std::fclose(file) != 0)
    error.assign(errno, std::generic_category());
  else
    std::filesystem::rename(temporary_, path_, error);
  if (!error) return;
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
  fail(path_, error.message());
}

void make_folder(const std::filesystem::path& folder, std::optional<long> resumed_at) {
  std::error_code error;
  if (std::filesystem::is_symlink(std::filesystem::symlink_status(folder, error)))
    fail(folder, "it is a link, and where it leads to is no part of the run");
  std::filesystem::create_directories(folder, error);
  if (error) fail(folder, error.message());
  if (!resumed_at) return;
  std::vector<std::filesystem::path> frames;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (step_of(entry.path().stem().string()) >= *resumed_at) frames.push_back(entry.path());
  for (const auto& frame : frames)
    if (!error) std::filesystem::remove(frame, error);
  if (error) fail(folder, error.message());
}

std::string numbered_name(const std::string& stem, long step, const std::string& extension) {
  std::string number = std::to_string(step);
  constexpr std::size_t kDigits = 6;  // so that names sort like numbers
  if (number.size() < kDigits) number.insert(0, kDigits - number.size(), '0');
  return stem + "_" + number + "." + extension;
}

void append_number(std::string& text, double value) { append_shortest(text, value); }
void append_number(std::string& text, long value) { append_shortest(text, value); }

}  // namespace deform::outputs
