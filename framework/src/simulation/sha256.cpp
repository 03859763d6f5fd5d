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

struct FreeContext {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};

void require(bool done, const std::filesystem::path& file, const char* what) {
  if (!done) {
    throw Error(ExitCode::internal_error,
                fmt::format("cannot compute the hash of {}: {}", file.string(), what));
  }
}

}  // namespace

std::string sha256_of_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  require(in.is_open(), file, "it cannot be opened");
  const std::unique_ptr<EVP_MD_CTX, FreeContext> context(EVP_MD_CTX_new());
  require(context && EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1, file,
          "no SHA-256 in this OpenSSL");

  std::array<char, 1U << 16U> buffer{};
  while (in) {
    in.read(buffer.data(), buffer.size());
    const auto count = static_cast<std::size_t>(in.gcount());
    require(EVP_DigestUpdate(context.get(), buffer.data(), count) == 1, file, "digest failed");
  }
  require(!in.bad() && in.eof(), file, "it cannot be read");

  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  require(EVP_DigestFinal_ex(context.get(), digest.data(), &size) == 1, file, "digest failed");
  std::string text;
  for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

}  // namespace deform
