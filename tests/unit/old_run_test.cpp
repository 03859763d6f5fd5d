/// What a new run replaces stays until the new one has taken a step, whenever it is killed before.
#include "simulation/old_run.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>

#include "deform/error.h"

#include "simulation/folder_lock.h"
#include "simulation/run_directory.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

class OldRun : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "deform_old_run_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    put("manifest.json", R"({"program": "deform"})");
    fs::create_directories(folder_ / "vtk");
    put("vtk/frame.vtp", "old");
    put("probes.csv", "old");
    old_ = content();
  }
  void TearDown() override { fs::remove_all(folder_); }

  void put(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  /// All files but the lock.
  [[nodiscard]] std::map<std::string, std::string> content() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      if (!entry.is_regular_file() || entry.path().filename() == kLockFile) continue;
      std::ifstream in(entry.path());
      files[fs::relative(entry.path(), folder_)] = {std::istreambuf_iterator<char>(in), {}};
    }
    return files;
  }
  void write_new() const {
    put("manifest.json", "new");
    put("log.txt", "new");
    fs::create_directories(folder_ / "vtk");
    put("vtk/frame.vtp", "new");
  }

  fs::path folder_;
  std::map<std::string, std::string> old_;
};

TEST_F(OldRun, ComesBackWhole) {
  const FolderLock lock(folder_);
  set_old_run_aside(folder_);
  EXPECT_TRUE(has_old_run(folder_));
  write_new();
  give_old_run_back(folder_);
  EXPECT_EQ(content(), old_);
  EXPECT_FALSE(has_old_run(folder_));
}

TEST_F(OldRun, GoesWhenItIsDropped) {
  set_old_run_aside(folder_);
  write_new();
  drop_old_run(folder_);
  EXPECT_FALSE(has_old_run(folder_));
  EXPECT_EQ(content().size(), 3U);
  EXPECT_EQ(content().at("vtk/frame.vtp"), "new");
  give_old_run_back(folder_);  // nothing is
  EXPECT_EQ(content().size(), 3U);
}

TEST_F(OldRun, KilledWhileItIsMovedNothingIsLost) {
  // The manifest goes last: until then the folder is known by it.
  fs::create_directory(folder_ / ".deform-old-moving");
  fs::rename(folder_ / "vtk", folder_ / ".deform-old-moving" / "vtk");
  EXPECT_NO_THROW(check_run_directory(folder_, true));
  give_old_run_back(folder_);
  EXPECT_EQ(content(), old_);
}

TEST_F(OldRun, KilledBeforeTheFirstStepItIsKnownAndComesBack) {
  set_old_run_aside(folder_);
  EXPECT_NO_THROW(check_run_directory(folder_, true)) << "there is no manifest.json yet";
  give_old_run_back(folder_);
  EXPECT_EQ(content(), old_);
}

TEST_F(OldRun, KilledWhileItIsRemovedTheNewOneStays) {
  set_old_run_aside(folder_);
  write_new();
  fs::rename(folder_ / ".deform-old", folder_ / ".deform-old-gone");
  give_old_run_back(folder_);
  drop_old_run(folder_);
  EXPECT_EQ(content().size(), 3U);
  EXPECT_EQ(content().at("manifest.json"), "new");
}

TEST_F(OldRun, FolderThatIsHeldIsRefusedWithItsHolder) {
  {
    const FolderLock lock(folder_);
    try {
      const FolderLock second(folder_);
      FAIL() << "two hold it";
    } catch (const InputError& e) {
      const std::string message = e.what();
      EXPECT_NE(message.find("process " + std::to_string(::getpid())), std::string::npos)
          << message;
      EXPECT_NE(message.find(" since 2"), std::string::npos) << message;
    }
    EXPECT_THROW(require_unheld(folder_), InputError);
  }
  EXPECT_FALSE(fs::exists(folder_ / kLockFile));
  put(kLockFile, "process 1 on a machine that went down");  // what a killed one leaves
  EXPECT_NO_THROW(require_unheld(folder_));
  const FolderLock next(folder_);
}

TEST_F(OldRun, TextOfALockIsShownAsPlainText) {
  const FolderLock lock(folder_);
  put(kLockFile, "\x1b[31mred\x07 and more\nsecond line");
  try {
    require_unheld(folder_);
    FAIL() << "it is held";
  } catch (const InputError& e) {
    const std::string message = e.what();
    EXPECT_EQ(message.find('\x1b'), std::string::npos);
    EXPECT_NE(message.find("?[31mred? and more:"), std::string::npos) << message;
  }
}

TEST_F(OldRun, LockThatIsALinkIsNotFollowed) {
  put("precious", "kept");
  fs::create_symlink(folder_ / "precious", folder_ / kLockFile);
  EXPECT_THROW(FolderLock{folder_}, Error);
  EXPECT_EQ(content().at("precious"), "kept");
}

}  // namespace
}  // namespace deform
