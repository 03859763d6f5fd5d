/// Runs that are stopped and resumed end with the same bits as those that are not.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>

#include <gmock/gmock.h>

#include "deform/simulation/run.h"

#include "support/simulate.h"

namespace deform {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Everything that has a memory, and everything that depends on the time: a constraint that moves,
/// a load that ends, probes and outputs that are due at different steps, the mirror image.
const std::string kScene = R"({
  "surface": {"plugin": "grid", "nodes": [7, 6], "differences": "forward", "border": "paper",
              "weights": "equal"},
  "material": {"density": 0.1, "damping": 1.0},
  "energies": [
    {"plugin": "stretching", "eta": 0.1},
    {"plugin": "bending", "xi": 1e-6, "normal": {"plugin": "gauss", "delta": 0.5}}],
  "forces": [{"plugin": "gravity", "acceleration": [0, 0, -1], "time": {"pulse": [0, 0.3]}}],
  "constraints": [
    {"plugin": "pin", "where": {"boundary": "left"}},
    {"plugin": "move", "where": {"boundary": "right"}, "times": [0, 0.5],
     "displacements": [[0, 0, 0], [-0.2, 0, 0.05]]}],
  "integrator": {"plugin": "semi_implicit", "step": 0.02},
  "duration": 0.8,
  "checkpoint": {"seconds": 0},
  "outputs": [{"plugin": "vtk", "every": 5}, {"plugin": "obj", "every": 7},
              {"plugin": "one_file", "every": 3}],
  "probes": ["energy", {"plugin": "lowest", "every": 4}, {"plugin": "mirror_asymmetry", "every": 3},
             {"plugin": "normal_error", "every": 2}, {"plugin": "energy_balance", "every": 3},
             "momentum"]
})";

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Resume : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "deform_resume_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] Scene scene(const std::vector<Replacement>& replacements = {}) const {
    return read_scene_text(kScene, "resume.json", ".", *registry_, replacements);
  }

  /// Runs until `steps` are done, or to the end; goes on where it was when `resume` is set.
  RunResult run_in(const fs::path& folder, const Scene& scene, bool resume, long steps = -1) {
    std::atomic<bool> stop = steps == 0;
    RunOptions options;
    options.folder = folder;
    options.resume = resume;
    options.interrupted = &stop;
    options.progress = [&](long done, long /*total*/) { stop = done == steps; };
    return run(scene, registry_, options);
  }

  /// What a run computed, by file: all but what tells of the run itself.
  [[nodiscard]] static std::map<std::string, std::string> results(const fs::path& folder) {
    const std::set<std::string> left_out{"log.txt", "manifest.json"};
    std::map<std::string, std::string> files;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file() || left_out.contains(entry.path().filename())) continue;
      files[fs::relative(entry.path(), folder)] = content_of(entry.path());
    }
    return files;
  }

  /// Stops a run at every step and resumes it: all results must be those of the run without a stop.
  void stop_everywhere(const Scene& scene) {
    const fs::path whole = folder_ / "whole";
    ASSERT_EQ(run_in(whole, scene, false).code, ExitCode::done);
    const auto expected = results(whole);
    ASSERT_TRUE(expected.contains("checkpoint.bin"));
    // Before the first step nothing is written yet.
    for (long k = 1; k < scene.steps(); ++k) {
      const fs::path parts = folder_ / std::to_string(k);
      const RunResult stopped = run_in(parts, scene, false, k);
      ASSERT_EQ(stopped.code, ExitCode::interrupted) << stopped.reason;
      ASSERT_EQ(stopped.steps, k);
      const RunResult resumed = run_in(parts, scene, true);
      ASSERT_EQ(resumed.code, ExitCode::done) << resumed.reason;
      EXPECT_EQ(resumed.resumed_after, k);
      const auto found = results(parts);
      ASSERT_EQ(found.size(), expected.size()) << "stopped at step " << k;
      for (const auto& [file, content] : expected)
        ASSERT_TRUE(found.contains(file) && found.at(file) == content)
            << file << " differs after a stop at step " << k;
      fs::remove_all(parts);
    }
  }

  std::string refusal(const fs::path& folder, const Scene& scene) {
    try {
      (void)run_in(folder, scene, true);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }

  std::shared_ptr<const PluginRegistry> registry_ =
      std::make_shared<const PluginRegistry>(std::vector<fs::path>{DEFORM_FIXTURE_PLUGINS});
  fs::path folder_;
};

TEST_F(Resume, FromEveryStepToTheSameBits) { stop_everywhere(scene()); }

TEST_F(Resume, IntegratorThatRemembersToTheSameBits) {
  stop_everywhere(
      scene({{"/integrator", R"({"plugin": "two_step", "step": 0.005})"}, {"/duration", "0.2"}}));
}

TEST_F(Resume, SymmetricMatrixToTheSameBits) {
  stop_everywhere(scene({{"/energies/1", R"({"plugin": "bending_variational", "xi": 1e-6})"}}));
}

TEST_F(Resume, MultigridAndQuickNewtonStepsToTheSameBits) {
  stop_everywhere(scene({{"/energies/1", R"({"plugin": "bending_variational", "xi": 1e-6})"},
                         {"/solver", R"({"plugin": "multigrid"})"},
                         {"/integrator", R"({"plugin": "backward_euler", "step": 0.02,
                                             "newton_error": 1e-4})"},
                         {"/probes", R"(["newton", "time_step", "energy_balance"])"},
                         {"/duration", "0.3"}}));
}

TEST_F(Resume, StepsOfItsOwnToTheSameBits) {
  stop_everywhere(scene({{"/energies/1", R"({"plugin": "bending_variational", "xi": 1e-6})"},
                         {"/integrator", R"({"plugin": "bdf2", "step": 0.05, "error": 1e-3})"},
                         {"/probes", R"(["newton", "time_step"])"},
                         {"/duration", "0.3"}}));
}

TEST_F(Resume, WithShadowsToTheSameBits) {
  stop_everywhere(scene({{"/shadow", R"(["exact", {"plugin": "gauss", "delta": 0.2}])"}}));
}

TEST_F(Resume, SeveralTimesToTheSameBits) {
  const Scene all = scene();
  ASSERT_EQ(run_in(folder_ / "whole", all, false).code, ExitCode::done);
  for (const long stop : {3L, 4L, 17L, 39L}) (void)run_in(folder_ / "parts", all, stop > 3, stop);
  ASSERT_EQ(run_in(folder_ / "parts", all, true).code, ExitCode::done);
  EXPECT_EQ(results(folder_ / "whole"), results(folder_ / "parts"));
}

TEST_F(Resume, FromAnOlderCheckpointThanTheLastRow) {
  const Scene all = scene({{"/checkpoint/every", "9"}});
  ASSERT_EQ(run_in(folder_ / "whole", all, false).code, ExitCode::done);
  const fs::path parts = folder_ / "parts";
  (void)run_in(parts, all, false, 20);
  const std::string at_20 = content_of(parts / "checkpoint.bin");
  (void)run_in(parts, all, true, 33);
  std::ofstream(parts / "checkpoint.bin", std::ios::binary) << at_20;
  std::ofstream(parts / "vtk" / "surface_000040.vtp.part") << "half a frame";
  ASSERT_EQ(run_in(parts, all, true).resumed_after, 20);
  EXPECT_EQ(results(folder_ / "whole"), results(parts));
}

TEST_F(Resume, FinishedRunIsLeftAlone) {
  ASSERT_EQ(run_in(folder_ / "run", scene(), false).code, ExitCode::done);
  const auto before = results(folder_ / "run");
  const RunResult again = run_in(folder_ / "run", scene(), true);
  EXPECT_EQ(again.code, ExitCode::done);
  EXPECT_THAT(again.reason, HasSubstr("finished"));
  EXPECT_EQ(results(folder_ / "run"), before);
}

TEST_F(Resume, FinishedRunCanBeProlonged) {
  // 40 and 50 steps: the last frame of the shorter run is not due in the longer one.
  const std::vector<Replacement> frames{{"/outputs", R"([{"plugin": "vtk", "every": 3}, "obj"])"}};
  std::vector<Replacement> longer = frames;
  longer.push_back({"/duration", "1.0"});
  ASSERT_EQ(run_in(folder_ / "whole", scene(longer), false).code, ExitCode::done);
  ASSERT_EQ(run_in(folder_ / "parts", scene(frames), false).code, ExitCode::done);
  const RunResult prolonged = run_in(folder_ / "parts", scene(longer), true);
  ASSERT_EQ(prolonged.code, ExitCode::done) << prolonged.reason;
  EXPECT_EQ(prolonged.resumed_after, 40);
  EXPECT_EQ(results(folder_ / "whole"), results(folder_ / "parts"));
  EXPECT_THAT(refusal(folder_ / "parts", scene(frames)), HasSubstr("the scene ends with step 40"));
}

TEST_F(Resume, WithoutACheckpointItStartsAnew) {
  ASSERT_EQ(run_in(folder_ / "whole", scene(), false).code, ExitCode::done);
  const fs::path parts = folder_ / "parts";
  EXPECT_EQ(run_in(parts, scene(), true, 11).code, ExitCode::interrupted);  // there is no folder
  fs::remove(parts / "checkpoint.bin");
  const RunResult anew = run_in(parts, scene(), true);
  EXPECT_EQ(anew.resumed_after, 0);
  EXPECT_EQ(results(folder_ / "whole"), results(parts));
  EXPECT_THAT(content_of(parts / "log.txt"), HasSubstr("starts anew"));
}

TEST_F(Resume, KilledBeforeItsFirstFileItStartsAnew) {
  fs::create_directories(folder_ / "run");
  std::ofstream(folder_ / "run" / "manifest.json.part") << "{ \"progr";
  EXPECT_EQ(run_in(folder_ / "run", scene(), true).code, ExitCode::done);
}

TEST_F(Resume, AnotherSceneIsRefusedWithTheReason) {
  (void)run_in(folder_ / "run", scene(), false, 5);
  const auto before = results(folder_ / "run");
  const Scene other = scene({{"/material/density", "0.2"}});
  EXPECT_THAT(refusal(folder_ / "run", other),
              testing::AllOf(HasSubstr("another scene"), HasSubstr("/material/density")));
  std::ofstream(folder_ / "run" / "scene.json") << other.completed;
  EXPECT_THAT(refusal(folder_ / "run", other),
              testing::AllOf(HasSubstr("checkpoint.bin"), HasSubstr("another scene")));
  fs::remove(folder_ / "run" / "scene.json");
  EXPECT_THAT(refusal(folder_ / "run", scene()), HasSubstr("no scene.json"));
  std::ofstream(folder_ / "run" / "scene.json") << scene().completed;
  (void)run_in(folder_ / "run", scene(), true, 6);  // and nothing was harmed
  EXPECT_EQ(results(folder_ / "run").size(), before.size());
}

TEST_F(Resume, WhatIsNoCheckpointIsRefusedAndLeftAlone) {
  const fs::path run = folder_ / "run";
  (void)run_in(run, scene(), false, 5);
  std::ofstream(run / "checkpoint.bin") << "not one";
  EXPECT_THAT(refusal(run, scene()),
              testing::AllOf(HasSubstr("checkpoint.bin"), HasSubstr("not a checkpoint")));
  EXPECT_EQ(content_of(run / "checkpoint.bin"), "not one");
}

TEST_F(Resume, TableThatIsShorterThanTheCheckpointSaysIsRefused) {
  const fs::path run = folder_ / "run";
  (void)run_in(run, scene(), false, 5);
  fs::resize_file(run / "probes.csv", 10);
  EXPECT_THAT(refusal(run, scene()), HasSubstr("probes.csv has 10 bytes only"));
  fs::remove(run / "probes.csv");
  EXPECT_THAT(refusal(run, scene()), HasSubstr("probes.csv is not there"));
}

TEST_F(Resume, FolderOfSomebodyElseIsRefused) {
  fs::create_directories(folder_ / "thesis");
  std::ofstream(folder_ / "thesis" / "text.tex") << "years";
  EXPECT_THAT(refusal(folder_ / "thesis", scene()), HasSubstr("manifest.json"));
}

TEST_F(Resume, DivergenceKeepsTheCheckpointBeforeItAndCanBeReplayed) {
  const Scene bad =
      scene({{"/forces/0", R"({"plugin": "nan", "from": 0.29})"}, {"/checkpoint/every", "4"}});
  const RunResult diverged = run_in(folder_ / "run", bad, false);
  ASSERT_EQ(diverged.code, ExitCode::diverged) << diverged.reason;
  EXPECT_EQ(diverged.steps, 14);  // the middle of the next is at 0.29 s
  const auto before = results(folder_ / "run");
  const RunResult again = run_in(folder_ / "run", bad, true);
  EXPECT_EQ(again.code, ExitCode::diverged);
  EXPECT_EQ(again.reason, diverged.reason);
  EXPECT_EQ(again.resumed_after, 12);
  EXPECT_EQ(results(folder_ / "run"), before);
}

}  // namespace
}  // namespace deform
