#include "deform/plugin/field.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deform/error.h"
#include "deform/surface/surface.h"

#include "support/fake_surface.h"

namespace deform {
namespace {

using testing::HasSubstr;

const ParameterRectangle kWithin{Vec2(0, 0), Vec2(2, 1)};

template <class F>
std::string message_of(F&& f) {
  try {
    f();
  } catch (const InputError& error) {
    return error.problems()[0].pointer + ": " + error.what();
  }
  return "";
}

FieldRules positive() {
  FieldRules rules{.pointer = "/energies/0/k", .unit = "N/m"};
  rules.minimum = 0;
  rules.minimum_excluded = true;
  return rules;
}

TEST(Field, IsANumber) {
  const Field field = 2.5;
  EXPECT_TRUE(field.is_constant());
  EXPECT_EQ(field(Vec2(7, 8), kWithin), 2.5);
  EXPECT_EQ(Field().constant(), 0);
  EXPECT_EQ(field.values(Eigen::MatrixX2d::Random(4, 2), kWithin), NodeValues::Constant(4, 2.5));
}

TEST(Field, IsAFormula) {
  const Field field = Field::formula("0.01*(1+a1) + a2");
  EXPECT_FALSE(field.is_constant());
  EXPECT_EQ(field.source(), "0.01*(1+a1) + a2");
  EXPECT_DOUBLE_EQ(field(Vec2(1, 3), kWithin), 3.02);
}

TEST(Field, SaysWhereItBreaksItsRules) {
  const Field field = Field::formula("a1 - 0.5", positive());
  EXPECT_DOUBLE_EQ(field(Vec2(0.75, 0), kWithin), 0.25);
  EXPECT_EQ(message_of([&] { (void)field(Vec2(0.25, 1), kWithin); }),
            "/energies/0/k: a1 - 0.5 is -0.25 at a1 = 0.25, a2 = 1, expected a "
            "finite number > 0 [N/m]");
  EXPECT_THAT(message_of([&] { (void)field(Vec2(0.5, 1), kWithin); }), HasSubstr("is 0 at a1"));
  const Field infinite = Field::formula("1/a1");
  EXPECT_THAT(message_of([&] { (void)infinite(Vec2(0, 0), kWithin); }),
              HasSubstr("1/a1 is inf at a1 = 0, a2 = 0, expected a finite number"));
  FieldRules below;
  below.maximum = 1;
  EXPECT_THROW((void)Field::formula("a1", below)(Vec2(1.5, 0), kWithin), InputError);
}

class FieldMap : public testing::Test {
 public:
  FieldMap()
      : file(std::filesystem::path(testing::TempDir()) /
             (std::string("field_test_") +
              testing::UnitTest::GetInstance()->current_test_info()->name())) {}
  ~FieldMap() override { std::filesystem::remove(file); }
  [[nodiscard]] Field read(const std::string& text, const FieldRules& rules = {}) const {
    std::ofstream(file) << text;
    return Field::map(file, rules);
  }
  std::filesystem::path file;
};

TEST_F(FieldMap, IsBilinearOverTheRectangle) {
  const Field field = read("# along a1\n1, 2, 3\n\n 5\t6 7 # along a1, at the end of a2\n");
  EXPECT_EQ(field.source(), file.string());
  EXPECT_EQ(field(Vec2(0, 0), kWithin), 1);
  EXPECT_EQ(field(Vec2(2, 0), kWithin), 3);
  EXPECT_EQ(field(Vec2(0, 1), kWithin), 5);
  EXPECT_EQ(field(Vec2(2, 1), kWithin), 7);
  EXPECT_DOUBLE_EQ(field(Vec2(0.5, 0.25), kWithin), 2.5);  // linear in both: 1 + a1 + 4 a2
  EXPECT_EQ(field(Vec2(-1, -1), kWithin), 1);
  const ParameterRectangle elsewhere{Vec2(10, 20), Vec2(12, 21)};
  EXPECT_DOUBLE_EQ(field(Vec2(10.5, 20.25), elsewhere), 2.5);
}

TEST_F(FieldMap, MayBeOneRowColumnOrNumber) {
  EXPECT_DOUBLE_EQ(read("1 3")(Vec2(0.5, 0.3), kWithin), 1.5);
  EXPECT_DOUBLE_EQ(read("1\n3\n")(Vec2(0.5, 0.25), kWithin), 1.5);
  EXPECT_EQ(read("4")(Vec2(0.5, 0.25), kWithin), 4);
}

TEST_F(FieldMap, KeepsItsRulesBetweenItsValues) {
  const Field field = read("-1 1", positive());
  EXPECT_EQ(field(Vec2(2, 0), kWithin), 1);
  EXPECT_THAT(message_of([&] { (void)field(Vec2(0.5, 0), kWithin); }),
              HasSubstr("is -0.5 at a1 = 0.5, a2 = 0"));
}

TEST_F(FieldMap, SaysWhatIsWrongWithItsFile) {
  const auto complaint = [this](const std::string& text) {
    return message_of([&] { (void)read(text); });
  };
  EXPECT_THAT(complaint("1 2\n3\n"), HasSubstr(":2: has 1 numbers, but the first row has 2"));
  EXPECT_THAT(complaint("1 x\n"), HasSubstr(":1: 'x' is not a finite number"));
  EXPECT_THAT(complaint("# nothing\n"), HasSubstr("has no numbers"));
  EXPECT_THAT(message_of([] { (void)Field::map("/nowhere/map.csv"); }),
              HasSubstr("there is no such file"));
}

TEST(Field, IsEvaluatedAtNodes) {
  test::FakeSurface surface(3, 2);
  EXPECT_EQ(parameter_rectangle(surface).upper, Vec2(1, 0.5));
  EXPECT_EQ(Field::formula("a1 + 10*a2").at_nodes(surface),
            (NodeValues(6) << 0, 0.5, 1, 5, 5.5, 6).finished());
  surface.set_period(1.5);
  EXPECT_EQ(parameter_rectangle(surface).upper, Vec2(1.5, 0.5));
}

SampleSet three_samples() {
  SampleSet::Builder builder(1);
  for (const double a1 : {0.0, 1.0, 2.0}) {
    SampleStencil sample;
    sample.weight = 1;
    sample.parameter = Vec2(a1, 0);
    sample.entries = {{0, {1}}};
    builder.add(sample);
  }
  return builder.build();
}

TEST(PairWeightsField, GivesWeightsAtSamples) {
  const test::FakeSurface surface(3, 2);
  const SampleSet samples = three_samples();
  const PairWeightsField varies({Field(2), Field::formula("a1"), Field::formula("a1*a1")});
  EXPECT_FALSE(varies.is_constant());
  const WeightsAtSamples weights = varies.at_samples(surface, samples);
  EXPECT_EQ(weights[2].w, (std::array{2.0, 2.0, 4.0}));
  EXPECT_EQ(weights[1](Pair::p12), 1);
  EXPECT_EQ(Field::formula("3*a1").at_samples(surface, samples), NodeValues(Vec3(0, 3, 6)));
}

TEST(PairWeightsField, KeepsConstantOnesOnce) {
  const PairWeightsField constant = PairWeights{{1, 2, 3}};
  EXPECT_TRUE(constant.is_constant());
  const WeightsAtSamples weights = constant.at_samples(test::FakeSurface(3, 2), three_samples());
  EXPECT_EQ(weights[0].w, (std::array{1.0, 2.0, 3.0}));
  EXPECT_EQ(&weights[0], &weights[2]);
}

}  // namespace
}  // namespace deform
