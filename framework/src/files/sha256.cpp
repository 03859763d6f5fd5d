#include "files/sha256.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "deform/error.h"

namespace deform {
namespace {

void require(bool done, const std::string& what) {
  if (!done) throw Error(ExitCode::internal_error, fmt::format("cannot compute a hash: {}", what));
}

[[noreturn]] void fail(const std::filesystem::path& file, const char* why) {
  throw Error(ExitCode::internal_error,
              fmt::format("cannot compute the hash of {}: {}", file.string(), why));
}

struct FreeContext {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};
using OwnedContext = std::unique_ptr<EVP_MD_CTX, FreeContext>;

}  // namespace

struct Sha256::Context {
  OwnedContext state{EVP_MD_CTX_new()};
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  EVP_MD_CTX* const state = context_->state.get();
  require(state != nullptr && EVP_DigestInit_ex(state, EVP_sha256(), nullptr) == 1,
          "no SHA-256 in this OpenSSL");
}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::add(std::string_view bytes) {
  require(EVP_DigestUpdate(context_->state.get(), bytes.data(), bytes.size()) == 1,
          "digest failed");
}

std::string Sha256::digits() const {
  const OwnedContext ended(EVP_MD_CTX_new());  // what comes later goes on from the state
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  require(ended && EVP_MD_CTX_copy_ex(ended.get(), context_->state.get()) == 1 &&
              EVP_DigestFinal_ex(ended.get(), digest.data(), &size) == 1,
          "digest failed");
  std::string text;
  for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

std::uintmax_t add_file(Sha256& hash, const std::filesystem::path& file, std::uintmax_t most) {
  std::error_code error;
  // A pipe may never begin.
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
    fail(file, "it is not a regular file");
  std::ifstream in(file, std::ios::binary);
  if (!in.is_open()) fail(file, "it cannot be opened");
  std::array<char, 1U << 16U> buffer{};
  std::uintmax_t done = 0;
  while (in && done < most) {
    in.read(buffer.data(),
            static_cast<std::streamsize>(std::min<std::uintmax_t>(buffer.size(), most - done)));
    const auto count = static_cast<std::size_t>(in.gcount());
    hash.add({buffer.data(), count});
    done += count;
  }
  if (in.bad() || (!in && !in.eof())) fail(file, "it cannot be read");
  return done;
}

std::string sha256_of_file(const std::filesystem::path& file) {
  Sha256 hash;
  (void)add_file(hash, file);
  return hash.digits();
}

std::string sha256_of(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.digits();
}

}  // namespace deform
