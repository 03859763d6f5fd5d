/// Numbers that are not finite are seen in the step in which they appear, and who gave them is
/// named.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>

#include "deform/simulation/run.h"

#include "support/simulate.h"

namespace deform {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string kScene = R"({
  "surface": {"plugin": "grid", "nodes": [7, 6], "differences": "forward",
              "border": "one_sided", "weights": "equal"},
  "energies": [
    {"plugin": "stretching", "eta": 0.1},
    {"plugin": "bending", "xi": 1e-6, "normal": {"plugin": "exact"}}],
  "forces": [{"plugin": "gravity", "acceleration": [0, 0, -1]}],
  "constraints": [{"plugin": "pin", "where": {"boundary": "left"}}],
  "integrator": {"plugin": "semi_implicit", "step": 0.02},
  "duration": 0.4,
  "outputs": ["vtk"],
  "probes": ["energy", "net_force", "lowest"]
})";

class NotFiniteNumbers : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "deform_finite_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = fs::path(name);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] Scene scene(const std::vector<Replacement>& replacements) const {
    return read_scene_text(kScene, "nan.json", ".", *registry_, replacements);
  }

  /// Of a run that records nothing, so that only steps find it.
  [[nodiscard]] Diverged divergence(std::vector<Replacement> replacements) const {
    replacements.insert(replacements.end(), {{"/outputs", "[]"}, {"/probes", "[]"}});
    Simulation simulation(scene(replacements), registry_);
    const auto diverged = test::run_to_end(simulation);
    if (!diverged) throw std::runtime_error("the run did not diverge");
    EXPECT_TRUE(simulation.state().r.allFinite());
    EXPECT_EQ(simulation.steps() + 1, diverged->step());
    return *diverged;
  }

  /// A run that records everything: its table and its files have no number that is not finite.
  void expect_clean_files(const std::vector<Replacement>& replacements, const std::string& guilty) {
    RunOptions options;
    options.folder = folder_ / "run";
    const RunResult result = run(scene(replacements), registry_, options);
    EXPECT_EQ(result.code, ExitCode::diverged) << result.reason;
    EXPECT_THAT(result.reason, HasSubstr(guilty));
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(options.folder)) {
      if (entry.path().extension() == ".csv") expect_no_word(entry.path());
      if (entry.path().extension() == ".vtp") expect_finite_doubles(entry.path());
    }
  }

 private:
  static std::string content_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static void expect_no_word(const fs::path& table) {
    std::string text = content_of(table);
    text.erase(0, text.find('\n'));  // names of plugins
    EXPECT_EQ(text.find("nan"), std::string::npos);
    EXPECT_EQ(text.find("inf"), std::string::npos);
    EXPECT_EQ(text.find(",,"), std::string::npos) << "figures are missing:\n" << text;
  }
  /// The appended data of a file: blocks of a length and its bytes, all doubles but the last two.
  static void expect_finite_doubles(const fs::path& file) {
    const std::string text = content_of(file);
    std::size_t at = text.find("<AppendedData");
    at = text.find('_', at) + 1;
    const std::size_t end = text.rfind("\n</AppendedData>");
    std::vector<std::string> blocks;
    while (at < end) {
      std::uint64_t size = 0;
      std::memcpy(&size, text.data() + at, sizeof(size));
      blocks.push_back(text.substr(at + sizeof(size), size));
      at += sizeof(size) + size;
    }
    ASSERT_GT(blocks.size(), 5U);
    for (std::size_t b = 0; b + 2 < blocks.size(); ++b)
      for (std::size_t i = 0; i < blocks[b].size(); i += sizeof(double)) {
        double number = 0;
        std::memcpy(&number, blocks[b].data() + i, sizeof(number));
        ASSERT_TRUE(std::isfinite(number)) << file << ", array " << b;
      }
  }

 protected:
  std::shared_ptr<const PluginRegistry> registry_ =
      std::make_shared<const PluginRegistry>(std::vector<fs::path>{DEFORM_FIXTURE_PLUGINS});
  fs::path folder_;
};

TEST_F(NotFiniteNumbers, OfAForceAreItsOwn) {
  const Diverged diverged = divergence({{"/forces/0", R"({"plugin": "nan", "from": 0.09})"}});
  EXPECT_EQ(diverged.step(), 5);  // whose middle is at 0.09 s
  EXPECT_EQ(diverged.node(), 0);
  EXPECT_EQ(diverged.term(), "nan");
  EXPECT_THAT(diverged.what(), HasSubstr("force-nan.so"));
}

TEST_F(NotFiniteNumbers, OfAnEnergyAreItsOwn) {
  const Diverged diverged = divergence({{"/energies/0", R"({"plugin": "nan", "beyond": 0.001})"}});
  EXPECT_GT(diverged.step(), 1);
  EXPECT_GE(diverged.node(), 0);
  EXPECT_EQ(diverged.term(), "nan");
  EXPECT_THAT(diverged.what(), HasSubstr("energy-nan.so"));
}

TEST_F(NotFiniteNumbers, OfANormalAreItsTerms) {
  const Diverged diverged = divergence({{"/energies/1/normal", R"({"plugin": "nan"})"}});
  EXPECT_EQ(diverged.step(), 1);
  EXPECT_EQ(diverged.term(), "bending");
}

TEST_F(NotFiniteNumbers, OfAnIntegratorAreItsOwn) {
  const Diverged diverged = divergence({{"/integrator/plugin", "nan"}});
  EXPECT_EQ(diverged.step(), 1);
  EXPECT_EQ(diverged.node(), 3);
  EXPECT_EQ(diverged.term(), "nan");
  EXPECT_THAT(diverged.what(), HasSubstr("integrator-nan.so"));
}

TEST_F(NotFiniteNumbers, OfASolverAreItsOwn) {
  const Diverged diverged = divergence({{"/solver", R"({"plugin": "nan"})"}});
  EXPECT_EQ(diverged.step(), 1);
  EXPECT_EQ(diverged.term(), "nan");
  EXPECT_THAT(diverged.what(), HasSubstr("solver-nan.so"));
}

TEST_F(NotFiniteNumbers, OfAConstraintAreItsOwn) {
  const Diverged diverged = divergence({{"/constraints/0", R"({"plugin": "nan", "from": 0.09})"}});
  EXPECT_EQ(diverged.step(), 5);  // which ends at 0.1 s
  EXPECT_EQ(diverged.node(), 4);
  EXPECT_EQ(diverged.term(), "nan");
  EXPECT_THAT(diverged.what(), HasSubstr("constraint-nan.so"));
}

TEST_F(NotFiniteNumbers, OfAForceReachNoFile) {
  expect_clean_files({{"/forces/0", R"({"plugin": "nan", "from": 0.09})"}}, "force-nan.so");
}

TEST_F(NotFiniteNumbers, OfAnEnergyReachNoFile) {
  expect_clean_files({{"/energies/0", R"({"plugin": "nan", "beyond": 0.001})"}}, "energy-nan.so");
}

TEST_F(NotFiniteNumbers, OfANormalReachNoFile) {
  expect_clean_files({{"/energies/1/normal", R"({"plugin": "nan"})"}}, "bending");
}

}  // namespace
}  // namespace deform
