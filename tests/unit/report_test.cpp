#include "deform/report/report.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "deform/error.h"

#include "report/base64.h"
#include "report/json_text.h"
#include "report/levels.h"
#include "report/report_page.h"
#include "report/shown_mesh.h"
#include "report/shown_moments.h"
#include "report/thinning.h"

namespace deform {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// RFC 4648, section 10.
TEST(Base64Writer, WritesTheStandardsExamples) {
  const std::array<std::pair<std::string, std::string>, 7> examples{{{"", ""},
                                                                     {"f", "Zg=="},
                                                                     {"fo", "Zm8="},
                                                                     {"foo", "Zm9v"},
                                                                     {"foob", "Zm9vYg=="},
                                                                     {"fooba", "Zm9vYmE="},
                                                                     {"foobar", "Zm9vYmFy"}}};
  for (const auto& [bytes, expected] : examples) {
    std::string text;
    Base64Writer writer(text);
    writer.append(std::span<const char>(bytes));
    writer.finish();
    EXPECT_EQ(text, expected);
    EXPECT_EQ(decode_base64(text), bytes);
  }
}

TEST(Base64Writer, PartsMakeTheTextOfTheWhole) {
  std::mt19937 random(1);
  std::string bytes(1000, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  for (int attempt = 0; attempt < 50; ++attempt) {
    std::string text = "before:";
    Base64Writer writer(text);
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t count = std::min<std::size_t>(random() % 9, bytes.size() - at);
      writer.append(std::span<const char>(bytes.data() + at, count));
      at += count;
    }
    writer.finish();
    ASSERT_EQ(text.substr(0, 7), "before:");
    ASSERT_EQ(decode_base64(text.substr(7)), bytes);
  }
}

TEST(Base64, RefusesWhatIsNone) {
  EXPECT_THROW((void)decode_base64("Zg="), InputError);
  EXPECT_THROW((void)decode_base64("Z<=="), InputError);
}

double value_of(const LevelRange& range, std::uint16_t level) {
  return range.min() + (range.max() - range.min()) * level / kMostLevel;
}

TEST(LevelRange, RoundsToHalfALevel) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> somewhere(-0.3, 12.7);
  std::vector<double> values(500);
  LevelRange range;
  for (double& value : values) range.add(value = somewhere(random));
  const double half = (range.max() - range.min()) / kMostLevel / 2;
  for (const double value : values)
    EXPECT_NEAR(value_of(range, range.level(value)), value, half * (1 + 1e-9));
  EXPECT_EQ(range.level(range.min()), 0);
  EXPECT_EQ(range.level(range.max()), kMostLevel);
}

TEST(LevelRange, KnowsWhatIsMissing) {
  LevelRange range;
  EXPECT_EQ(range.level(kNaN), kNoLevel);
  EXPECT_EQ(range.min(), 0);
  EXPECT_EQ(range.max(), 0);
  for (const double value : {kNaN, 3.0, std::numeric_limits<double>::infinity()}) range.add(value);
  EXPECT_EQ(range.min(), 3);
  EXPECT_EQ(range.max(), 3);
  EXPECT_EQ(range.level(3), 0) << "a single value is the minimum";
  EXPECT_EQ(range.level(std::numeric_limits<double>::infinity()), kNoLevel);
}

TEST(LevelRange, SurvivesTheLargestNumbers) {
  const double largest = std::numeric_limits<double>::max();
  LevelRange range;
  range.add(-largest);
  range.add(largest);
  EXPECT_EQ(range.level(0), kMostLevel / 2);
  EXPECT_EQ(range.level(largest), kMostLevel);
}

TEST(LevelOfCategory, IsItsNumber) {
  EXPECT_EQ(level_of_category(0), 0);
  EXPECT_EQ(level_of_category(3), 3);
  EXPECT_EQ(level_of_category(kNaN), kNoLevel);
  EXPECT_EQ(level_of_category(-1), kNoLevel);
}

TEST(ReportPage, HasOnePlaceForTheData) {
  const std::string place = R"(<script id="deform-data" type="application/json">null</script>)";
  const ReportPage page("<p>" + place + "</p>");
  EXPECT_EQ(std::string(page.before()) + "{}" + std::string(page.after()),
            R"(<p><script id="deform-data" type="application/json">{}</script></p>)");
  EXPECT_THROW(ReportPage(""), InputError);
  EXPECT_THROW(ReportPage(place + place), InputError);
}

TEST(JsonText, CannotEndTheElementItStandsIn) {
  std::string text;
  JsonText json(text);
  json.begin('{');
  json.member("title", "</script><b>&");
  json.member("none", kNaN);
  json.key("list");
  json.begin('[');
  json.value(1);
  json.value("<");
  json.end(']');
  json.key("data");
  json.text([](std::string& to) { to += "Zg=="; });
  json.end('}');
  EXPECT_EQ(text.find('<'), std::string::npos);
  const Json read = Json::parse(text);
  EXPECT_EQ(read["title"], "</script><b>&");
  EXPECT_TRUE(read["none"].is_null());
  EXPECT_EQ(read["list"], Json({1, "<"}));
  EXPECT_EQ(read["data"], "Zg==");
}

TEST(JsonText, TakesBytesThatAreNoText) {
  std::string text;
  JsonText(text).value("\xff");
  EXPECT_FALSE(Json::parse(text, nullptr, false).is_discarded());
}

/// Nodes in an order that no arrangement could be read from; `joined`: the first side follows the
/// last.
TrajectoryMesh made_mesh(int columns, int rows, bool joined = false) {
  TrajectoryMesh mesh;
  const int count = columns * rows;
  std::vector<std::int32_t> number(static_cast<std::size_t>(count));
  std::iota(number.begin(), number.end(), 0);
  std::ranges::shuffle(number, std::mt19937(3));
  const auto node = [&](int i, int j) {
    return number[static_cast<std::size_t>(j * columns + i % columns)];
  };
  mesh.parameters.resize(count, 2);
  mesh.areas.setOnes(count);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) mesh.parameters.row(node(i, j)) << 0.1 * i, 0.2 * j;
  }
  for (int j = 0; j + 1 < rows; ++j) {
    for (int i = 0; i + (joined ? 0 : 1) < columns; ++i) {
      for (const std::int32_t k : {node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)})
        mesh.faces.nodes.push_back(k);
      mesh.faces.begin.push_back(static_cast<std::int32_t>(mesh.faces.nodes.size()));
    }
  }
  return mesh;
}

/// Signed area of a face in the parameter plane.
double area(const ShownMesh& shown, Index face) {
  const auto at = [&](int k) -> Vec2 {
    const auto begin = shown.faces.begin[static_cast<std::size_t>(face)];
    return shown.parameters.row(shown.faces.nodes[static_cast<std::size_t>(begin + k)]);
  };
  const Vec2 u = at(2) - at(0), v = at(3) - at(1);
  return (u.x() * v.y() - u.y() * v.x()) / 2;
}

TEST(ParameterLattice, EverySecondNodeCoversTheSurface) {
  const TrajectoryMesh mesh = made_mesh(18, 33);  // 17 cells: the last strip is a narrow one
  const auto lattice = ParameterLattice::of(mesh);
  ASSERT_TRUE(lattice);
  const ShownMesh shown = lattice->every(2);
  EXPECT_EQ(shown.numbers.size(), 10U * 17U);
  EXPECT_EQ(lattice->nodes(2), shown.numbers.size());
  EXPECT_FALSE(shown.is_whole);
  EXPECT_EQ(shown.faces.size(), 9 * 16);
  double sum = 0;
  for (Index face = 0; face < shown.faces.size(); ++face) {
    EXPECT_GT(area(shown, face), 0);
    sum += area(shown, face);
  }
  EXPECT_NEAR(sum, 1.7 * 6.4, 1e-12);
  for (std::size_t k = 0; k < shown.numbers.size(); ++k)
    EXPECT_EQ(shown.parameters.row(static_cast<Index>(k)), mesh.parameters.row(shown.numbers[k]));
}

TEST(ParameterLattice, KeepsOrientation) {
  TrajectoryMesh mesh = made_mesh(17, 17);
  for (std::size_t f = 0; f + 1 < mesh.faces.begin.size(); ++f)
    std::swap(mesh.faces.nodes[4 * f + 1], mesh.faces.nodes[4 * f + 3]);
  const auto lattice = ParameterLattice::of(mesh);
  ASSERT_TRUE(lattice);
  const ShownMesh shown = lattice->every(2);
  for (Index face = 0; face < shown.faces.size(); ++face) EXPECT_LT(area(shown, face), 0);
}

TEST(ParameterLattice, JoinedSidesStayJoined) {
  const TrajectoryMesh mesh = made_mesh(32, 17, true);
  const auto lattice = ParameterLattice::of(mesh);
  ASSERT_TRUE(lattice);
  const ShownMesh shown = lattice->every(2);
  const auto columns = static_cast<Index>(shown.numbers.size() / 9);
  EXPECT_EQ(shown.faces.size(), columns * 8);
}

TEST(ParameterLattice, ShortSidesKeepSomeNodes) {
  const auto lattice = ParameterLattice::of(made_mesh(200, 5));
  ASSERT_TRUE(lattice);
  EXPECT_EQ(lattice->nodes(10) % 5, 0U);
}

TEST(ParameterLattice, IsNotSeenWhereThereIsNone) {
  TrajectoryMesh holed = made_mesh(9, 9);
  holed.faces.begin.pop_back();
  EXPECT_FALSE(ParameterLattice::of(holed)) << "a face is missing";
  TrajectoryMesh moved = made_mesh(9, 9);
  moved.parameters(40, 0) += 0.01;
  EXPECT_FALSE(ParameterLattice::of(moved));
  TrajectoryMesh triangles = made_mesh(3, 3);
  triangles.faces.nodes = {0, 1, 2};
  triangles.faces.begin = {0, 3};
  EXPECT_FALSE(ParameterLattice::of(triangles));
  EXPECT_FALSE(ParameterLattice::of(TrajectoryMesh{}));
}

std::vector<Moment> moments(double step, long count, long stride = 1) {
  std::vector<Moment> all;
  for (long i = 0; i < count; ++i)
    all.push_back({i * stride, static_cast<double>(i * stride) * step});
  return all;
}

TEST(ShownMoments, AreThoseOfTheOneThatGotFarthest) {
  const auto shown = shown_moments({moments(0.1, 3), {}, moments(0.1, 11)}, 9);
  EXPECT_EQ(shown.moments.size(), 11U);
  EXPECT_THAT(shown.frames[0], ElementsAre(0, 1, 2));
  EXPECT_TRUE(shown.frames[1].empty());
  EXPECT_EQ(shown.frames[2].size(), 11U);
}

TEST(ShownMoments, AreMatchedByTime) {
  // The finer one takes two steps for each, and is recorded at every third of its own.
  const auto shown = shown_moments({moments(0.1, 13), moments(0.05, 9, 3)}, 1);
  std::vector<long> steps;
  for (const Moment& moment : shown.moments) steps.push_back(moment.step);
  EXPECT_THAT(steps, ElementsAre(0, 3, 6, 9, 12));
  EXPECT_THAT(shown.frames[0], ElementsAre(0, 3, 6, 9, 12));
  EXPECT_THAT(shown.frames[1], ElementsAre(0, 2, 4, 6, 8));
}

TEST(ShownMoments, TheLastChoiceIsTakenWhereThereIsNoOther) {
  const auto shown = shown_moments({{}, moments(0.1, 4)}, 1);
  EXPECT_EQ(shown.moments.size(), 4U);
  EXPECT_TRUE(shown_moments({{}, {}}, 0).moments.empty());
}

TEST(ShownMoments, ThinnedOnesKeepTheEnd) {
  const auto all = shown_moments({moments(0.1, 10), moments(0.1, 6)}, 9);
  const auto some = every(4, all);
  EXPECT_THAT(some.frames[0], ElementsAre(0, 4, 8, 9));
  EXPECT_THAT(some.frames[1], ElementsAre(0, 4));
  EXPECT_THAT(every(3, 1), ElementsAre(0));
  EXPECT_TRUE(every(3, 0).empty());
}

ReportExtent extent(std::size_t side, std::size_t frames, std::size_t variants) {
  ReportExtent extent;
  extent.nodes = [side](std::size_t stride) {
    const std::size_t kept = (side - 1) / std::min(stride, side / 8) + 1;
    return kept * kept;
  };
  extent.moments = frames;
  extent.fields = 3;
  extent.variants.assign(variants, {.frames = frames, .fields = {0, 1, 2}});
  return extent;
}

TEST(Thinning, LeavesSmallReportsAlone) {
  const Thinning t = choose_thinning(extent(21, 100, 3), 50'000'000);
  EXPECT_EQ(t.node_stride, 1U);
  EXPECT_EQ(t.frame_stride, 1U);
  EXPECT_EQ(t.fields, 3U);
  EXPECT_EQ(t.shapes, 3U);
}

TEST(Thinning, AnySizeFits) {
  for (const std::size_t side : {21, 257, 2000}) {
    for (const std::size_t variants : {1, 3, 60, 1000}) {
      for (const std::size_t bytes : {1'000'000, 56'000'000}) {
        const ReportExtent all = extent(side, 1000, variants);
        EXPECT_LE(bytes_of(all, choose_thinning(all, bytes)), bytes);
      }
    }
  }
}

TEST(Thinning, NodesGoBeforeFramesAndFramesBeforeFields) {
  const Thinning large = choose_thinning(extent(257, 100, 2), 56'000'000);
  EXPECT_GT(large.node_stride, 1U);
  EXPECT_EQ(large.frame_stride, 1U);
  EXPECT_EQ(large.fields, 3U);
  const Thinning many = choose_thinning(extent(21, 1000, 60), 56'000'000);
  EXPECT_EQ(many.node_stride, 1U);
  EXPECT_GT(many.frame_stride, 1U);
  EXPECT_EQ(many.fields, 3U);
}

TEST(WriteReport, RefusesOtherFolders) {
  const auto folder = std::filesystem::temp_directory_path() / "deform-no-run";
  std::filesystem::create_directories(folder);
  try {
    (void)write_report(folder);
    FAIL() << "it is neither a run nor a comparison";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("neither a run directory nor a comparison"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove(folder);
}

}  // namespace
}  // namespace deform
