#include "simulation/checkpoint.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include <gmock/gmock.h>

#include "deform/error.h"

#include "files/files.h"
#include "files/sha256.h"
#include "simulation/scene_files.h"

namespace deform {
namespace {

using testing::HasSubstr;

Checkpoint example() {
  Checkpoint checkpoint;
  checkpoint.scene = identity_of("{}", {});
  checkpoint.step = 12345678901;
  checkpoint.files = {{"probes.csv", 4711, sha256_of("rows")}, {"vtk/surface_000000.vtp", 17, ""}};
  checkpoint.memory.put("state/r", {0.1, -0.0, std::numeric_limits<double>::denorm_min()});
  checkpoint.memory.put("probe/x/none", {});
  checkpoint.memory.put("probes/figures", {kInfinity, std::numeric_limits<double>::quiet_NaN()});
  return checkpoint;
}

std::string refusal(std::string_view content) {
  try {
    (void)decode_checkpoint(content, "runs/a/checkpoint.bin");
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

/// The content with some bytes replaced, and a checksum that is right.
template <class Number>
std::string forged(std::size_t at, Number number) {
  std::string content = encoded(example());
  content.resize(content.size() - 64);
  std::memcpy(content.data() + at, &number, sizeof(number));
  return sealed(std::move(content));
}

// Where the numbers stand: after "deform checkpoint\n" and, further on, the identity.
constexpr std::size_t kVersionAt = 18, kStepAt = kVersionAt + 4 + 64, kFileCountAt = kStepAt + 8,
                      kFileNameLengthAt = kFileCountAt + 8, kHashLengthAt = kFileNameLengthAt + 8,
                      kFileNameAt = kHashLengthAt + 16,
                      // Behind both files, one of which has a hash.
    kCountAt = kFileNameLengthAt + 2 * 24 + 10 + 64 + 22, kNameLengthAt = kCountAt + 8,
                      kListLengthAt = kNameLengthAt + 8;

TEST(CheckpointFile, ComesBackBitByBit) {
  const Checkpoint written = example();
  const std::string content = encoded(written);
  const Checkpoint read = decode_checkpoint(content, "file");
  EXPECT_EQ(read.scene, written.scene);
  EXPECT_EQ(read.step, written.step);
  ASSERT_EQ(read.files.size(), written.files.size());
  for (std::size_t i = 0; i < read.files.size(); ++i) {
    EXPECT_EQ(read.files[i].name, written.files[i].name);
    EXPECT_EQ(read.files[i].bytes, written.files[i].bytes);
    EXPECT_EQ(read.files[i].sha256, written.files[i].sha256);
  }
  ASSERT_NE(read.file("probes.csv"), nullptr);
  EXPECT_EQ(read.file("trajectory.bin"), nullptr);
  ASSERT_EQ(read.memory.entries().size(), written.memory.entries().size());
  EXPECT_EQ(encoded(read), content);  // NaN and −0 included
}

TEST(CheckpointFile, CutShortAnywhereItIsRefused) {
  const std::string content = encoded(example());
  for (std::size_t size = 0; size < content.size(); ++size) {
    const std::string reason = refusal(std::string_view(content).substr(0, size));
    EXPECT_THAT(reason, HasSubstr("cannot resume from runs/a/checkpoint.bin: ")) << size;
  }
}

TEST(CheckpointFile, WithAnyBitFlippedItIsRefused) {
  std::string content = encoded(example());
  for (std::size_t bit = 0; bit < 8 * content.size(); ++bit) {
    const auto flip = [&] {
      content[bit / 8] = static_cast<char>(content[bit / 8] ^ (1 << bit % 8));
    };
    flip();
    EXPECT_NE(refusal(content), "") << "bit " << bit;
    flip();
  }
  EXPECT_EQ(refusal(content), "");
}

TEST(CheckpointFile, SaysWhatIsWrong) {
  EXPECT_THAT(refusal(""), HasSubstr("not a checkpoint of deform"));
  EXPECT_THAT(refusal("step,time [s]\n0,0\n1,0.1\n"), HasSubstr("not a checkpoint of deform"));
  EXPECT_THAT(refusal(forged<std::uint32_t>(kVersionAt, 2)),
              HasSubstr("version 2, this program reads version 3"));
  EXPECT_THAT(refusal(encoded(example()) + "x"), HasSubstr("checksum is wrong"));
  EXPECT_THAT(refusal(forged<std::int64_t>(kStepAt, -1)), HasSubstr("steps is negative"));
}

TEST(CheckpointFile, BelievesNoLengthThatGoesBeyondItsEnd) {
  for (const std::uint64_t length : {std::uint64_t{1} << 20U, std::uint64_t{1} << 61U,
                                     (std::uint64_t{1} << 61U) + 1, ~std::uint64_t{0}}) {
    EXPECT_NE(refusal(forged(kFileCountAt, length)), "") << length;
    EXPECT_NE(refusal(forged(kFileNameLengthAt, length)), "") << length;
    EXPECT_NE(refusal(forged(kHashLengthAt, length)), "") << length;
    EXPECT_NE(refusal(forged(kCountAt, length)), "") << length;
    EXPECT_NE(refusal(forged(kNameLengthAt, length)), "") << length;
    EXPECT_NE(refusal(forged(kListLengthAt, length)), "") << length;
  }
  EXPECT_THAT(refusal(forged<std::uint64_t>(kCountAt, 2)), HasSubstr("longer than"));
}

TEST(CheckpointFile, KnowsNoFileOutsideOfTheRunDirectory) {
  for (const char* name : {"../etc/pass", "/etc/passwd", "vtk/../ab", "./probes.c"}) {
    std::array<char, 10> forged_name{};
    std::copy_n(name, std::min<std::size_t>(std::strlen(name), 10), forged_name.begin());
    EXPECT_THAT(refusal(forged(kFileNameAt, forged_name)), HasSubstr("none of a run directory"));
  }
}

TEST(CheckpointIdentity, IsThatOfWhatTheRunComputes) {
  const auto of = [](const char* text) { return identity_of(text, {}); };
  const std::string scene =
      of(R"({"title": "a", "duration": 1, "material": {"density": 0.1, "damping": 1}})");
  EXPECT_EQ(scene.size(), 64U);
  EXPECT_EQ(scene, of(R"({"material": {"damping": 1, "density": 0.1},
      "checkpoint": {"seconds": 3}, "duration": 7, "title": "a"})"));
  EXPECT_NE(scene, of(R"({"title": "a", "duration": 1, "material": {"density": 0.2}})"));
  EXPECT_EQ(of("no JSON"), "");
}

TEST(CheckpointIdentity, IsThatOfWhatItsFilesHoldWhereverTheyLie) {
  const auto of = [](const char* text, const char* content) {
    return identity_of(text, {{"/surface/shape/path", "/", sha256_of(content)}});
  };
  const char *here = R"({"surface": {"shape": {"path": "/a/rest.txt"}}})",
             *there = R"({"surface": {"shape": {"path": "../rest.txt"}}})";
  EXPECT_EQ(of(here, "0 0 0"), of(there, "0 0 0"));
  EXPECT_NE(of(here, "0 0 0"), of(here, "0 0 1"));
}

TEST(CheckpointSchedule, CountsStepsAndTime) {
  Scene scene;
  scene.checkpoint_every = 5;
  scene.checkpoint_seconds = 0;
  const CheckpointSchedule by_steps(scene);
  EXPECT_TRUE(by_steps.due(0));
  EXPECT_FALSE(by_steps.due(4));
  EXPECT_TRUE(by_steps.due(5));
  scene.checkpoint_every = 0;
  EXPECT_FALSE(CheckpointSchedule(scene).due(5)) << "both are off";
  scene.checkpoint_seconds = 1e-9;
  EXPECT_TRUE(CheckpointSchedule(scene).due(3));
  scene.checkpoint_seconds = 1e9;
  EXPECT_FALSE(CheckpointSchedule(scene).due(3));
}

}  // namespace
}  // namespace deform
