#include "simulation/run_directory.h"

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "deform/error.h"

#include "files/files.h"
#include "files/sha256.h"
#include "simulation/probe_table.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void put(const fs::path& file, const std::string& content) {
  std::ofstream(file, std::ios::binary) << content;
}

class RunDirectory : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "deform_run_directory_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

/// Lets no file of this process grow beyond a size, as a full disk does.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, old_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit old_{};
  void (*handler_)(int) = nullptr;
};

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST_F(RunDirectory, AtomicWriteReplacesTheWholeFileAndLeavesNothingElse) {
  const fs::path file = folder_ / "manifest.json";
  write_atomically(file, "a first, longer content");
  write_atomically(file, "second");
  EXPECT_EQ(content_of(file), "second");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(RunDirectory, FailedAtomicWriteNamesFileAndCauseAndKeepsTheOldContent) {
  const fs::path file = folder_ / "summary.json";
  write_atomically(file, "old");
  std::string message;
  {
    const FileSizeLimit limit(1000);
    message = message_of([&] { write_atomically(file, std::string(2000, 'x')); });
  }
  EXPECT_NE(message.find(file.string()), std::string::npos) << message;
  EXPECT_NE(message.find("File too large"), std::string::npos) << message;
  EXPECT_EQ(content_of(file), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(RunDirectory, AtomicWriteIntoNoFolderIsAnInternalError) {
  try {
    write_atomically(folder_ / "absent" / "file", "x");
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::internal_error);
  }
}

TEST_F(RunDirectory, FailedAppendLeavesWholeRecordsOnly) {
  const fs::path file = folder_ / "probes.csv";
  AppendFile table(file);
  table.append("1,2\n");
  std::string message;
  {
    const FileSizeLimit limit(6);  // half of the next record fits
    message = message_of([&] { table.append("3,4\n"); });
  }
  EXPECT_NE(message.find(file.string()), std::string::npos) << message;
  EXPECT_EQ(content_of(file), "1,2\n");
  table.append("5,6\n");
  EXPECT_EQ(content_of(file), "1,2\n5,6\n");
}

TEST_F(RunDirectory, HashIsThatOfTheStandard) {
  // FIPS 180-2, appendix B: one block, two blocks, a million times "a".
  put(folder_ / "one", "abc");
  put(folder_ / "two", "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq");
  put(folder_ / "million", std::string(1000000, 'a'));
  EXPECT_EQ(sha256_of_file(folder_ / "one"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of_file(folder_ / "two"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_of_file(folder_ / "million"),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_THROW((void)sha256_of_file(folder_ / "absent"), Error);
}

TEST_F(RunDirectory, NewFolderIsMadeWithItsParents) {
  const fs::path run = folder_ / "runs" / "sheet";
  EXPECT_NO_THROW(check_run_directory(run, false));
  EXPECT_FALSE(fs::exists(run)) << "checking must change nothing";
  make_run_directory(run);
  EXPECT_TRUE(fs::is_directory(run));
}

TEST_F(RunDirectory, ExistingFolderNeedsForce) {
  EXPECT_THROW(check_run_directory(folder_, false), InputError);
  EXPECT_NO_THROW(check_run_directory(folder_, true)) << "an empty folder may be filled";
}

TEST_F(RunDirectory, ForceDoesNotReplaceWhatIsNoRunDirectory) {
  put(folder_ / "thesis.tex", "years of work");
  EXPECT_THROW(check_run_directory(folder_, true), InputError);
  put(folder_ / "manifest.json", R"({"program": "another"})");
  EXPECT_THROW(check_run_directory(folder_, true), InputError);
  put(folder_ / "manifest.json", "{ not JSON");
  EXPECT_THROW(check_run_directory(folder_, true), InputError);
  EXPECT_THROW(check_run_directory(folder_ / "thesis.tex", true), InputError);
  EXPECT_TRUE(fs::exists(folder_ / "thesis.tex"));
}

TEST_F(RunDirectory, ForceEmptiesARunDirectoryButFollowsNoLink) {
  const fs::path run = folder_ / "run";
  fs::create_directories(run / "vtk");
  fs::create_directories(folder_ / "elsewhere");
  put(folder_ / "elsewhere" / "file", "kept");
  put(run / "vtk" / "frame.vtu", "old");
  put(run / "manifest.json", R"({"program": "deform"})");
  fs::create_directory_symlink(folder_ / "elsewhere", run / "link");
  EXPECT_NO_THROW(check_run_directory(run, true));
  empty_run_directory(run);
  EXPECT_TRUE(fs::is_empty(run));
  EXPECT_EQ(content_of(folder_ / "elsewhere" / "file"), "kept");
}

TEST(ProbeTableText, FieldsAreQuotedWhereTheyMustBe) {
  EXPECT_EQ(csv_field("lowest [m]"), "lowest [m]");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("the \"best\""), "\"the \"\"best\"\"\"");
  EXPECT_EQ(csv_field("two\nlines"), "\"two\nlines\"");
}

TEST(ProbeTableText, RepeatedNamesGetANumber) {
  const auto columns = with_unique_names({{"lowest", "m"}, {"lowest", "m"}, {"time", "s"}});
  EXPECT_EQ(header_of(columns[0]), "lowest [m]");
  EXPECT_EQ(header_of(columns[1]), "lowest_2 [m]");
  EXPECT_EQ(header_of(columns[2]), "time_2 [s]");
  EXPECT_EQ(header_of({"mirror_asymmetry", ""}), "mirror_asymmetry");
}

TEST_F(RunDirectory, TableKeepsEveryBitAndLeavesOutWhatIsNoFigure) {
  const fs::path file = folder_ / "probes.csv";
  const std::vector<ProbeColumn> columns{{"lowest", "m"}, {"a,b", ""}};
  ProbeTable table(file, columns);
  const double third = 1.0 / 3.0;
  table.append(0, 0.0, std::vector<double>{kNoFigure, std::numeric_limits<double>::denorm_min()});
  table.append(5, 0.1, std::vector<double>{third, -0.0});
  const std::string text = content_of(file);
  EXPECT_EQ(text.substr(0, text.find('\n')), "step,time [s],lowest [m],\"a,b\"");
  EXPECT_NE(text.find("\n0,0,,5e-324\n"), std::string::npos) << text;
  const std::size_t row = text.find("\n5,0.1,");
  ASSERT_NE(row, std::string::npos) << text;
  EXPECT_EQ(std::stod(text.substr(row + 7)), third);
}

TEST(ColumnSummaryOfProbes, PassesOverMissingFigures) {
  ColumnSummary summary;
  summary.add(kNoFigure);
  EXPECT_TRUE(std::isnan(summary.last));
  for (const double figure : {2.0, -1.0, kNoFigure, 1.0, kNoFigure}) summary.add(figure);
  EXPECT_EQ(summary.last, 1.0);
  EXPECT_EQ(summary.minimum, -1.0);
  EXPECT_EQ(summary.maximum, 2.0);
}

}  // namespace
}  // namespace deform
