/// Mirror symmetry: a scene reflected at z = 0 must give the reflected states; and equal bits
/// whatever the number of threads and the order in which plugins are loaded.
#include <cstring>

#include <tbb/global_control.h>

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::built_in;
using test::run_to_end;
using test::simulation_of;

/// Largest distance between a node and the reflection of its mirror image, over all steps.
double mirror_asymmetry(Simulation& s) {
  const auto image = s.mirrored();
  double worst = 0;
  while (s.steps() < s.scene().steps()) {
    s.step();
    image->step();
    NodeVectors reflected = image->state().r;
    reflected.col(2) *= -1;
    worst = std::max(worst, (s.state().r - reflected).rowwise().norm().maxCoeff());
  }
  return worst;
}

TEST(Mirror, ImageOfARunIsTheRunOfTheImage) {
  for (const char* variant :
       {"gauss_expanded_1e-5", "gauss_divergence_1e-5", "exact_1e-5", "variational_1e-5"}) {
    Simulation s = simulation_of("benchmarks/sheet_p.json", variant);
    EXPECT_LE(mirror_asymmetry(s), 1e-12) << variant;
  }
}

TEST(Mirror, HoldsForACurvedRestShape) {
  for (const char* variant : {"exact", "variational", "gauss_expanded"}) {
    Simulation s = simulation_of("benchmarks/strip_s.json", variant);
    EXPECT_LE(mirror_asymmetry(s), 1e-12) << variant;
  }
}

TEST(Mirror, TerzopoulosNormalBreaksIt) {
  Simulation s = simulation_of("benchmarks/sheet_p.json", "terzopoulos_1e-6");
  EXPECT_NEAR(mirror_asymmetry(s), 0.164, 1e-3);
}

bool same_bits(const NodeVectors& a, const NodeVectors& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

TEST(Reproducibility, SameBitsAtAnyNumberOfThreads) {
  for (const char* variant : {"gauss_expanded_1e-5", "variational_1e-4", "terzopoulos_1e-6"}) {
    NodeVectors one;
    for (const std::size_t threads : {1, 2, 4}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      Simulation s = simulation_of("benchmarks/sheet_p.json", variant);
      ASSERT_FALSE(run_to_end(s));
      if (threads == 1) one = s.state().r;
      EXPECT_TRUE(same_bits(one, s.state().r)) << variant << " with " << threads << " threads";
    }
  }
}

TEST(Reproducibility, SameBitsWhateverTheLoadOrder) {
  NodeVectors first;
  for (const bool reversed : {false, true}) {
    const auto registry = std::make_shared<const PluginRegistry>();
    std::vector<PluginFile> files = registry->files();
    if (reversed) std::ranges::reverse(files);
    for (const PluginFile& file : files) (void)registry->load(file.kind, file.name);
    Simulation s(read_scene(test::scene_file("benchmarks/sheet_p.json"), *registry, {},
                            "gauss_expanded_1e-5"),
                 registry);
    ASSERT_FALSE(run_to_end(s));
    if (!reversed) first = s.state().r;
    EXPECT_TRUE(same_bits(first, s.state().r));
  }
}

}  // namespace
}  // namespace deform
