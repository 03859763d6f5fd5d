/// Shadows: estimators that are measured on the states that another one drives.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <unistd.h>

#include <gmock/gmock.h>

#include "deform/record/jet_terms.h"
#include "deform/simulation/run.h"

#include "support/simulate.h"

namespace deform {
namespace {

namespace fs = std::filesystem;
using testing::IsSupersetOf;

const std::string kSheet = R"({
  "surface": {"plugin": "grid", "nodes": [9, 8], "differences": "forward", "border": "paper",
              "weights": "equal"},
  "material": {"density": 0.1, "damping": 1.0},
  "energies": [
    {"plugin": "stretching", "eta": 0.01},
    {"plugin": "bending", "xi": 1e-6, "normal": {"plugin": "gauss", "delta": 0.5}}],
  "forces": [{"plugin": "point_load", "force": [0, 0, -0.01],
              "where": {"centre": [0.5, 0.5], "radius": 0.15}}],
  "constraints": [{"plugin": "pin", "where": {"boundary": "all"}}],
  "integrator": {"plugin": "semi_implicit", "step": 0.02},
  "duration": 0.6,
  "frames": {"write": false}
})";

/// A wave that stands still, for every node is held: the previous state is the present one.
const std::vector<Replacement> kHeld{
    {"/surface/initial", R"({"plugin": "wave", "amplitude": 0.1, "wavelength": 0.7})"},
    {"/constraints", R"([{"plugin": "pin", "where": {"box": [[-1, -1], [2, 2]]}}])"},
    {"/duration", "0.02"},
    {"/probes", R"(["normal_error"])"}};

/// probes.csv: a row's figures by their headers; nothing where a field is empty.
using Row = std::map<std::string, std::optional<double>>;

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields{""};
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

class Shadow : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "deform_shadow_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  static Scene scene(std::vector<Replacement> changes, const std::vector<Replacement>& more = {}) {
    changes.insert(changes.end(), more.begin(), more.end());
    return read_scene_text(kSheet, "sheet.json", ".", *test::built_in(), changes);
  }

  /// The rows that a scene's run measures.
  std::vector<Row> rows_of(const Scene& scene) {
    RunOptions options;
    options.folder = folder_ / "run";
    options.force = true;
    const RunResult result = run(scene, test::built_in(), options);
    EXPECT_EQ(result.code, ExitCode::done) << result.reason;
    std::ifstream file(options.folder / "probes.csv");
    std::string line;
    std::getline(file, line);
    const std::vector<std::string> headers = split(line);
    std::vector<Row> rows;
    while (std::getline(file, line)) {
      const std::vector<std::string> fields = split(line);
      Row& row = rows.emplace_back();
      for (std::size_t i = 0; i < headers.size(); ++i) {
        row[headers[i]] = fields[i].empty() ? std::nullopt : std::optional(std::stod(fields[i]));
      }
    }
    return rows;
  }

  /// Of a scene with the driver's own estimator as its only shadow: what differs, as text.
  std::string differences(const Scene& scene) {
    std::ostringstream found;
    const std::vector<Row> rows = rows_of(scene);
    std::size_t figures = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (const auto& [header, figure] : rows[i]) {
        if (!header.starts_with("shadow.") || !figure) continue;
        ++figures;
        if (*figure != 0) found << "row " << i << ", " << header << ": " << *figure << '\n';
      }
    }
    EXPECT_GT(figures, 4 * rows.size()) << "too few were measured";
    return found.str();
  }

  fs::path folder_;
};

TEST_F(Shadow, DriversOwnEstimatorDiffersByExactlyNothing) {
  for (const char* form : {R"("divergence")", R"("expanded")"}) {
    for (const char* normal :
         {R"({"plugin": "gauss", "delta": 0.5})", R"("exact")", R"("terzopoulos")"}) {
      SCOPED_TRACE(std::string(form) + ' ' + normal);
      EXPECT_EQ(differences(scene({{"/energies/1/form", form},
                                   {"/energies/1/normal", normal},
                                   {"/shadow/-", normal},
                                   {"/duration", "0.2"}})),
                "");
    }
  }
}

/// Terms before and between change the order of the sums that the run makes; shadows do not see it.
TEST_F(Shadow, DriversOwnEstimatorDiffersByNothingAmongOtherTerms) {
  const std::string bending =
      R"({"plugin": "bending", "xi": 2e-6, "form": "expanded", "normal": "exact"})";
  EXPECT_EQ(differences(scene({{"/energies/-", R"({"plugin": "edge_springs"})"},
                               {"/energies/-", bending},
                               {"/energies/1/normal", R"("exact")"},
                               {"/shadow/-", R"("exact")"},
                               {"/duration", "0.2"}})),
            "");
}

TEST_F(Shadow, ColumnsOfEveryTermAndShadowWithUniqueNames) {
  const Scene two = scene({{"/energies/-", R"({"plugin": "bending", "normal": "exact"})"},
                           {"/shadow", R"(["gauss", {"plugin": "gauss", "delta": 1}])"},
                           {"/duration", "0.04"}});
  ASSERT_EQ(two.shadows.size(), 4U);
  const std::vector<Row> rows = rows_of(two);
  std::vector<std::string> headers;
  for (const auto& [header, figure] : rows.front()) headers.push_back(header);
  for (const char* name : {"gauss", "gauss_2"}) {
    for (const char* term : {"bending", "bending_2"}) {
      const std::string front = std::string("shadow.") + name + '.' + term + '.';
      EXPECT_THAT(headers, IsSupersetOf({front + "angle.mean [rad]", front + "angle.max [rad]",
                                         front + "force.rms [N]", front + "force.max [N]",
                                         front + "force.relative [1]"}));
    }
  }
  EXPECT_EQ(rows.size(), 3U);  // of every step: there is no other probe
  EXPECT_FALSE(rows[0].at("shadow.gauss.bending.angle.mean [rad]"));    // no previous state
  EXPECT_FALSE(rows[0].at("shadow.gauss.bending.force.relative [1]"));  // no force
  EXPECT_EQ(rows[0].at("shadow.gauss.bending.force.max [N]"), 0.0);
}

TEST_F(Shadow, IsMeasuredWheneverAnotherProbeIs) {
  const std::vector<Row> rows = rows_of(
      scene({{"/probes", R"([{"plugin": "lowest", "every": 7}])"}, {"/shadow", R"(["exact"])"}}));
  std::vector<double> steps;
  for (const Row& row : rows) steps.push_back(*row.at("step"));
  EXPECT_EQ(steps, (std::vector<double>{0, 7, 14, 21, 28, 30}));
  for (const Row& row : rows) EXPECT_TRUE(row.at("shadow.exact.bending.force.max [N]"));
}

TEST_F(Shadow, AngleToTheExactNormalIsThatOfNormalError) {
  const Replacement exact{"/energies/1/normal", R"("exact")"};
  const Row beside =
      rows_of(scene(kHeld, {exact, {"/shadow", R"(["gauss", "terzopoulos"])"}})).back();
  for (const char* name : {"gauss", "terzopoulos"}) {
    SCOPED_TRACE(name);
    const std::string quoted = '"' + std::string(name) + '"';
    const Replacement own{"/energies/1/normal", quoted};
    const Row driving = rows_of(scene(kHeld, {own, {"/shadow", R"(["exact"])"}})).back();
    for (const std::string figure : {"mean [rad]", "max [rad]"}) {
      const double expected = driving.at("normal_error.bending." + figure).value();
      EXPECT_GT(expected, 1e-3);
      EXPECT_EQ(beside.at("shadow." + std::string(name) + ".bending.angle." + figure), expected);
      EXPECT_EQ(driving.at("shadow.exact.bending.angle." + figure), expected);
    }
  }
}

/// Root mean square and largest length of the rows.
std::pair<double, double> rms_and_max(const NodeVectors& v) {
  return {std::sqrt(v.squaredNorm() / static_cast<double>(v.rows())),
          v.rowwise().norm().maxCoeff()};
}

TEST_F(Shadow, ForceIsThatOfASystemWithTheEstimator) {
  const Replacement exact{"/energies/1/normal", R"("exact")"};
  for (const char* form : {R"("divergence")", R"("expanded")"}) {
    SCOPED_TRACE(form);
    const Replacement of_form{"/energies/1/form", form};
    const Row last = rows_of(scene({of_form, {"/shadow", R"(["exact"])"}})).back();
    Simulation driver = test::simulation_from_text(kSheet, {of_form});
    ASSERT_FALSE(test::run_to_end(driver));
    Simulation other = test::simulation_from_text(kSheet, {of_form, exact});
    const NodeVectors own = driver.system().terms().internal_force(1, driver.state());
    const auto [rms, max] =
        rms_and_max(other.system().terms().internal_force(1, driver.state()) - own);
    EXPECT_GT(max, 0);
    const auto expect = [&last](const std::string& figure, double expected) {
      const double found = last.at("shadow.exact.bending.force." + figure).value();
      EXPECT_NEAR(found / expected, 1, 1e-12) << figure;
    };
    expect("rms [N]", rms);
    expect("max [N]", max);
    expect("relative [1]", rms / rms_and_max(own).first);
  }
}

TEST_F(Shadow, AngleIsThatOfPreviousCoefficientsOnThePresentJets) {
  const Row last = rows_of(scene({{"/shadow", R"(["exact"])"}})).back();
  Simulation driver = test::simulation_from_text(kSheet);
  State previous;
  while (driver.steps() < driver.scene().steps()) {
    previous = driver.state();
    driver.step();
  }
  Simulation other = test::simulation_from_text(kSheet, {{"/energies/1/normal", R"("exact")"}});
  std::array<std::vector<NodeVectors>, 2> normals;
  const SampleSet* samples = nullptr;
  for (std::size_t i = 0; i < 2; ++i) {
    const System& system = (i == 0 ? driver : other).system();
    const JetTermUse use = terms_with_normal(system).at(0);
    for (const Pair ij : kPairs) {
      estimate_normals(use, *system.terms().geometry(previous.r, *use.samples),
                       *system.terms().geometry(driver.state().r, *use.samples), ij,
                       normals[i].emplace_back());
    }
    samples = use.samples;
  }
  double sum = 0, weight = 0, max = 0;
  for (std::size_t ij = 0; ij < 3; ++ij) {
    for (Index s = 0; s < samples->size(); ++s) {
      const Vec3 a = normals[0][ij].row(s), b = normals[1][ij].row(s);
      if (a.isZero() || b.isZero()) continue;
      const double angle = std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
      const double w = samples->weights()[static_cast<std::size_t>(s)] * (ij == 1 ? 2 : 1);
      sum += w * angle, weight += w, max = std::max(max, angle);
    }
  }
  EXPECT_GT(max, 0.1);
  EXPECT_NEAR(last.at("shadow.exact.bending.angle.mean [rad]").value(), sum / weight, 1e-7);
  EXPECT_NEAR(last.at("shadow.exact.bending.angle.max [rad]").value(), max, 1e-7);
}

}  // namespace
}  // namespace deform
