#include "host/trusted_path.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <pwd.h>
#include <string>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/xattr.h>

namespace deform {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class TrustedPath : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) / ("trusted_" + std::to_string(::getpid()));
    fs::remove_all(root_);
    fs::create_directories(folder_ = root_ / "a" / "b");
    for (const fs::path& made : {root_, root_ / "a", folder_})
      fs::permissions(made, fs::perms::owner_all);
    if (!objection_to(root_).empty()) GTEST_SKIP() << "temporary files are not safe here";
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path root_, folder_;
};

TEST_F(TrustedPath, IsTheUsersAlone) {
  EXPECT_EQ(objection_to(folder_), "");
  EXPECT_EQ(objection_to("/"), "");
  EXPECT_EQ(objection_to(folder_ / "none"), "does not exist");
}

TEST_F(TrustedPath, IsWritableByNobodyElse) {
  fs::permissions(folder_, fs::perms::others_write, fs::perm_options::add);
  EXPECT_EQ(objection_to(folder_), "is world-writable");
  fs::permissions(folder_, fs::perms::sticky_bit, fs::perm_options::add);  // anybody may add files
  EXPECT_EQ(objection_to(folder_), "is world-writable");
  EXPECT_EQ(objection_to(folder_ / ""), "is world-writable");
  const fs::path library = folder_ / "normal-a.so";
  std::ofstream(library) << "";
  EXPECT_EQ(objection_to(library), "");  // sticky: nobody else replaces it
  fs::permissions(library, fs::perms::others_write, fs::perm_options::add);
  EXPECT_EQ(objection_to(library), "is world-writable");
}

TEST_F(TrustedPath, LiesInFoldersOfTheUser) {
  fs::permissions(root_ / "a", fs::perms::all);
  EXPECT_EQ(objection_to(folder_), "is not safe: " + (root_ / "a").string() + " is world-writable");
}

/// The user "nobody" for a while, whose primary group is that of others, too.
class AsNobody {
 public:
  AsNobody() { is_he_ = ::seteuid(kNobody) == 0; }
  ~AsNobody() { (void)!::seteuid(0); }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;
  [[nodiscard]] bool is_he() const { return is_he_; }
  static constexpr uid_t kNobody = 65534;

 private:
  bool is_he_;
};

TEST_F(TrustedPath, IsNotChangedByAnothersPrimaryGroup) {
  const passwd* const nobody = ::getpwuid(AsNobody::kNobody);
  if (::geteuid() != 0 || nobody == nullptr) GTEST_SKIP() << "for root alone";
  const gid_t group = nobody->pw_gid;
  bool is_anothers = false;
  ::setpwent();
  while (const passwd* user = ::getpwent())
    is_anothers = is_anothers || (user->pw_gid == group && user->pw_uid != AsNobody::kNobody);
  ::endpwent();
  if (!is_anothers) GTEST_SKIP() << "nobody has a group of his own";
  for (const fs::path& made : {root_, root_ / "a", folder_})
    ASSERT_EQ(::chown(made.c_str(), AsNobody::kNobody, group), 0);
  const AsNobody nobody_now;
  ASSERT_TRUE(nobody_now.is_he());
  EXPECT_EQ(objection_to(folder_), "");
  fs::permissions(folder_, fs::perms::group_write, fs::perm_options::add);
  EXPECT_THAT(objection_to(folder_), HasSubstr("is writable by a group"));
}

TEST_F(TrustedPath, IsNotChangedByAnAccessList) {
  fs::permissions(folder_, fs::perms::group_write, fs::perm_options::add);
  if (!objection_to(folder_).empty()) GTEST_SKIP() << "the user's group is not private";
  constexpr std::uint32_t kNoOne = ~0U;
  struct Entry {
    std::uint16_t tag, permissions;
    std::uint32_t id;
  };
  struct {
    std::uint32_t version = 2;
    Entry owner{1, 7, kNoOne}, user{2, 7, AsNobody::kNobody}, group{4, 7, kNoOne},
        mask{0x10, 7, kNoOne}, others{0x20, 0, kNoOne};
  } list;
  if (::setxattr(folder_.c_str(), "system.posix_acl_access", &list, sizeof list, 0) != 0)
    GTEST_SKIP() << "no access lists here";
  EXPECT_THAT(objection_to(folder_), HasSubstr("access control list"));
  fs::permissions(folder_, fs::perms::group_write, fs::perm_options::remove);  // the list's mask
  EXPECT_EQ(objection_to(folder_), "");
}

TEST_F(TrustedPath, IsNotChangedByGroups) {
  fs::permissions(folder_, fs::perms::group_write, fs::perm_options::add);
  // The primary group of whoever runs this may have other members or none.
  const std::string own = objection_to(folder_);
  EXPECT_TRUE(own.empty() || own.starts_with("is writable by a group")) << own;
  if (::geteuid() != 0) return;
  ASSERT_EQ(::chown(folder_.c_str(), 0, 12345), 0);
  EXPECT_EQ(objection_to(folder_), "is writable by a group (12345)");
}

TEST_F(TrustedPath, IsNoOtherUsers) {
  if (::geteuid() != 0) GTEST_SKIP() << "files are given away by root alone";
  ASSERT_EQ(::chown(folder_.c_str(), 12345, 12345), 0);
  EXPECT_EQ(objection_to(folder_), "belongs to another user (12345)");
  EXPECT_THAT(objection_to(folder_ / "none"), HasSubstr("belongs to another user (12345)"));
}

TEST_F(TrustedPath, IsThatOfWhatLinksLeadTo) {
  fs::create_directory_symlink("b", root_ / "a" / "link");
  EXPECT_EQ(objection_to(root_ / "a" / "link"), "");
  fs::create_directory_symlink(root_ / "a" / "link" / ".." / "b", root_ / "again");
  EXPECT_EQ(objection_to(root_ / "again"), "");
  fs::permissions(folder_, fs::perms::all);
  EXPECT_THAT(objection_to(root_ / "again"), HasSubstr("is world-writable"));
  fs::create_symlink("round", root_ / "round");
  EXPECT_EQ(objection_to(root_ / "round"), "cannot be followed");
  if (::geteuid() != 0) return;
  fs::permissions(folder_, fs::perms::owner_all);
  ASSERT_EQ(::lchown((root_ / "again").c_str(), 12345, 12345), 0);
  EXPECT_EQ(objection_to(root_ / "again"), "is a link of another user (12345)");
}

}  // namespace
}  // namespace deform
