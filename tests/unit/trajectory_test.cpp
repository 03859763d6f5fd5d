/// trajectory.bin: what is written comes back; what is not one is refused.
#include "deform/record/trajectory.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deform/error.h"
#include "deform/simulation/run.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = R"({
  "surface": {"plugin": "grid", "nodes": [6, 5], "size": [1.0, 2.0],
              "differences": "symmetric"},
  "energies": [{"plugin": "stretching", "eta": 0.1},
               {"plugin": "bending", "xi": 1e-4, "normal": "gauss"}],
  "forces": [{"plugin": "gravity", "acceleration": [0, 0, -1]}],
  "constraints": [{"plugin": "pin", "where": {"boundary": "left"}}],
  "integrator": {"plugin": "semi_implicit", "step": 0.001},
  "duration": 0.007, "probes": ["lowest"], "frames": {"every": 3}})";

class TrajectoryTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / ("deform_trajectory_" + std::string(info->name()));
    RunOptions options;
    options.folder = folder_;
    options.force = fs::exists(folder_);
    scene_ = read_scene_text(kScene, "scene.json", folder_, *registry_);
    ASSERT_EQ(run(scene_, registry_, options).code, ExitCode::done);
    file_ = folder_ / kTrajectoryFile;
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::shared_ptr<const PluginRegistry> registry_ =
      std::make_shared<const PluginRegistry>(std::vector<fs::path>{DEFORM_PLUGINS});
  fs::path folder_, file_;
  Scene scene_;
};

TEST_F(TrajectoryTest, HoldsTheStates) {
  const Trajectory trajectory(file_);
  ASSERT_EQ(trajectory.frames(), 4U);  // 0, 3, 6 and the last
  Simulation simulation(scene_, registry_);
  for (std::size_t frame = 0; frame < 4; ++frame) {
    while (simulation.steps() < trajectory.moments()[frame].step) simulation.step();
    EXPECT_EQ(trajectory.moments()[frame].time, simulation.state().time);
    EXPECT_EQ(trajectory.positions(frame), simulation.state().r);
  }
  EXPECT_EQ(simulation.steps(), 7);
}

TEST_F(TrajectoryTest, HoldsTheSurfaceAndItsFields) {
  const Trajectory trajectory(file_);
  Simulation simulation(scene_, registry_);
  const Surface& surface = simulation.system().surface();
  EXPECT_EQ(trajectory.mesh().parameters, surface.parameters());
  EXPECT_EQ(trajectory.mesh().areas, surface.areas());
  EXPECT_EQ(trajectory.mesh().faces.nodes, surface.faces().nodes);
  EXPECT_EQ(trajectory.mesh().faces.begin, surface.faces().begin);
  EXPECT_DOUBLE_EQ(trajectory.mesh().size, 2.0);

  std::vector<std::string> names;
  for (const TrajectoryField& field : trajectory.fields()) names.push_back(field.name);
  EXPECT_THAT(names, ::testing::ElementsAre("B_11", "B_12", "B_22", "energy density, stretching",
                                            "energy density, bending", "normal angle", "branch"));
  EXPECT_EQ(trajectory.fields().back().labels.size(), 4U);
  while (simulation.steps() < 6) simulation.step();
  const Frame frame = simulation.frame();
  const auto geometry = frame.geometry(surface.samples(SampleRole::bending));
  const ConstValues B_11 = geometry->all().B(Pair::p11);
  const std::vector<float> recorded = trajectory.field(2, 0);
  for (std::size_t i = 0; i < recorded.size(); ++i)
    EXPECT_EQ(recorded[i], static_cast<float>(B_11[i]));

  // The membrane's samples are not the nodes: means there, which add up to the energy.
  ASSERT_FALSE(surface.samples(SampleRole::membrane).samples_are_nodes());
  double energy = 0;
  const std::vector<float> density = trajectory.field(2, 3);
  for (std::size_t i = 0; i < density.size(); ++i)
    energy += surface.areas()[static_cast<Index>(i)] * static_cast<double>(density[i]);
  const double expected = frame.system.terms().energy(0, frame.state);
  EXPECT_GT(expected, 0);
  EXPECT_NEAR(energy / expected, 1, 1e-6);
}

TEST_F(TrajectoryTest, PassesOverAFrameThatIsCutOff) {
  fs::resize_file(file_, fs::file_size(file_) - 1);
  EXPECT_EQ(Trajectory(file_).frames(), 3U);
}

TEST_F(TrajectoryTest, RefusesWhatIsNone) {
  std::string bytes;
  {
    std::ifstream in(file_, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  const auto refused = [this](const std::string& content) {
    std::ofstream(file_, std::ios::binary) << content;
    try {
      const Trajectory trajectory(file_);
    } catch (const InputError& e) {
      return std::string(e.what()).find(kTrajectoryFile) != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refused(""));
  EXPECT_TRUE(refused("deform trajectory 2\n" + bytes.substr(20)));
  for (const std::size_t length : {10U, 20U, 27U, 100U})
    EXPECT_TRUE(refused(bytes.substr(0, length)));
  std::string huge = bytes;
  huge[26] = '\x7f';  // of the header's length
  EXPECT_TRUE(refused(huge));
  fs::remove(file_);
  EXPECT_THROW(Trajectory{file_}, InputError);
}

/// The places of a trajectory's parts, from its own header.
struct Layout {
  explicit Layout(const std::string& bytes) {
    std::uint64_t length = 0;
    std::memcpy(&length, bytes.data() + kMagicBytes, sizeof length);
    header = kMagicBytes + sizeof length;
    const std::size_t nodes = 6 * 5;
    parameters = header + length;
    areas = parameters + 16 * nodes;
    begin = areas + 8 * nodes;
    corners = begin + 4 * (5 * 4 + 1);
    frame = corners + 4 * (4 * 5 * 4);
  }
  static constexpr std::size_t kMagicBytes = 20;
  std::size_t header, parameters, areas, begin, corners, frame;
};

class HostileTrajectory : public TrajectoryTest {
 protected:
  void SetUp() override {
    TrajectoryTest::SetUp();
    std::ifstream in(file_, std::ios::binary);
    good_.assign(std::istreambuf_iterator<char>(in), {});
  }
  /// Why a file with other bytes somewhere is refused; "" where it is not.
  template <class T>
  std::string refusal(std::size_t at, T value) {
    std::string bytes = good_;
    std::memcpy(bytes.data() + at, &value, sizeof value);
    return refusal_of(bytes);
  }
  std::string refusal_of(const std::string& bytes) {
    std::ofstream(file_, std::ios::binary) << bytes;
    try {
      const Trajectory trajectory(file_);
      (void)trajectory.positions(0);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
  /// The header with another number of something, as long as before.
  std::string with_count(const std::string& key, const std::string& digits) {
    std::string bytes = good_;
    const std::size_t at = bytes.find("\"" + key + "\":") + key.size() + 3;
    const std::size_t end = bytes.find_first_of(",}", at);
    std::uint64_t length = 0;
    std::memcpy(&length, bytes.data() + Layout::kMagicBytes, sizeof length);
    length += digits.size() - (end - at);
    bytes.replace(at, end - at, digits);
    std::memcpy(bytes.data() + Layout::kMagicBytes, &length, sizeof length);
    return bytes;
  }

  std::string good_;
};

TEST_F(HostileTrajectory, BelievesNoIndexCountOrSize) {
  using ::testing::HasSubstr;
  const Layout at(good_);
  ASSERT_EQ(refusal_of(good_), "");
  for (const char* count : {"-1", "1e9", "2147483647", "4294967297", "18446744073709551615", "0"})
    for (const char* key : {"nodes", "faces", "corners"})
      EXPECT_NE(refusal_of(with_count(key, count)), "") << key << ' ' << count;
  EXPECT_THAT(refusal_of(with_count("size", "-1.0")), HasSubstr("no size"));
  for (const std::int32_t corner : {-1, 30, 1 << 30})
    EXPECT_THAT(refusal(at.corners, corner), HasSubstr("no node")) << corner;
  for (const std::int32_t begin : {-4, 1, 9, 1 << 30})
    EXPECT_THAT(refusal(at.begin + 4, begin), HasSubstr("faces")) << begin;
  EXPECT_THAT(refusal(at.begin, 1), HasSubstr("faces"));
}

TEST_F(HostileTrajectory, NumbersAreFiniteAndTimesAscend) {
  using ::testing::HasSubstr;
  const Layout at(good_);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(at.parameters, nan), HasSubstr("not finite"));
  EXPECT_THAT(refusal(at.areas, kInfinity), HasSubstr("not finite"));
  EXPECT_THAT(refusal(at.frame, std::int64_t{-1}), HasSubstr("ascend"));
  EXPECT_THAT(refusal(at.frame, std::int64_t{1} << 40), HasSubstr("ascend"));
  EXPECT_THAT(refusal(at.frame + 8, nan), HasSubstr("ascend"));
  EXPECT_THAT(refusal(at.frame + 8, 1e9), HasSubstr("ascend"));
  EXPECT_THAT(refusal(at.frame + 16, nan), HasSubstr("frame 0 is not finite"));
}

}  // namespace
}  // namespace deform
