#include "simulation/sha256.h"

#include <array>
#include <cstddef>
#include <fstream>
#include <memory>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "deform/error.h"

namespace deform {
namespace {

/// A hash that grows; `of` is what it is the hash of, for messages.
class Digest {
 public:
  explicit Digest(std::string of) : of_(std::move(of)), context_(EVP_MD_CTX_new()) {
    require(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1,
            "no SHA-256 in this OpenSSL");
  }

  void require(bool done, const char* what) const {
    if (done) return;
    throw Error(ExitCode::internal_error,
                fmt::format("cannot compute the hash of {}: {}", of_, what));
  }
  void add(const char* bytes, std::size_t count) {
    require(EVP_DigestUpdate(context_.get(), bytes, count) == 1, "digest failed");
  }
  [[nodiscard]] std::string text() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    require(EVP_DigestFinal_ex(context_.get(), digest.data(), &size) == 1, "digest failed");
    std::string text;
    for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
    return text;
  }

 private:
  struct FreeContext {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };
  std::string of_;
  std::unique_ptr<EVP_MD_CTX, FreeContext> context_;
};

}  // namespace

std::string sha256_of_file(const std::filesystem::path& file) {
  Digest digest(file.string());
  std::ifstream in(file, std::ios::binary);
  digest.require(in.is_open(), "it cannot be opened");
  std::array<char, 1U << 16U> buffer{};
  while (in) {
    in.read(buffer.data(), buffer.size());
    digest.add(buffer.data(), static_cast<std::size_t>(in.gcount()));
  }
  digest.require(!in.bad() && in.eof(), "it cannot be read");
  return digest.text();
}

std::string sha256_of(std::string_view bytes) {
  Digest digest("bytes in memory");
  digest.add(bytes.data(), bytes.size());
  return digest.text();
}

}  // namespace deform
