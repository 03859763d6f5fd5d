#include "plugin/trusted_path.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
