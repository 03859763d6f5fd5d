#include "deform/plugin/expression.h"

#include <array>
#include <cmath>
#include <numbers>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deform {
namespace {

using testing::HasSubstr;

double value(const std::string& text, double a1 = 0, double a2 = 0,
             const Expression::Constants& constants = {}) {
  return Expression(text, {"a1", "a2"}, constants)(std::array{a1, a2});
}

std::string complaint(const std::string& text, const Expression::Constants& constants = {}) {
  try {
    (void)Expression(text, {"a1", "a2"}, constants);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Expression, HasVariablesConstantsAndPi) {
  EXPECT_DOUBLE_EQ(value("0.1*sin(2*pi*a1) + a2^2", 0.25, 3), 9.1);
  EXPECT_DOUBLE_EQ(value("k*a1 + m", 2, 0, {{"k", 3}, {"m", 0.5}}), 6.5);
  EXPECT_EQ(value("a1 >= 0.5 && a2 != 1 ? 2 : 3", 0.5, 0), 2);
  EXPECT_EQ(value("1e-3*1000"), 1);
  EXPECT_TRUE(std::isinf(value("1/a1")));  // the caller's matter
  EXPECT_TRUE(std::isnan(value("sqrt(a1)", -1)));
}

TEST(Expression, SaysWhatIsWrong) {
  EXPECT_EQ(complaint("sin(b1)"),
            "found \"sin(b1)\", expected a formula of a1, a2: there is no \"b1\"; did you mean "
            "\"a1\"?");
  EXPECT_THAT(complaint("sine(a1)"), HasSubstr("there is no \"sine\"; did you mean \"sin\"?"));
  EXPECT_THAT(complaint("2*(a1"), HasSubstr("expected a formula of a1, a2: "));
  EXPECT_THAT(complaint(""), HasSubstr("expected a formula of a1, a2: "));
  EXPECT_THAT(complaint("a1 +"), HasSubstr("nexpected end of"));
  EXPECT_THAT(complaint("a1 a2"), HasSubstr("\"a2\""));
  EXPECT_THAT(complaint("a1 = 3"), HasSubstr("cannot assign: equal is =="));
  EXPECT_THAT(complaint("a1, a2"), HasSubstr("these are 2 formulas"));
  EXPECT_THAT(complaint(std::string(20000, '1')), HasSubstr("expected a formula"));
}

TEST(Expression, RefusesNamesOfConstants) {
  for (const char* taken : {"pi", "a1", "sin"})
    EXPECT_THAT(complaint("1", {{taken, 3}}), HasSubstr("has the name of something else")) << taken;
  for (const char* impossible : {"", "2x", "a b", "x-y"})
    EXPECT_THAT(complaint("1", {{impossible, 3}}), HasSubstr("a constant cannot be called"));
}

TEST(Expression, TakesManyConstants) {
  Expression::Constants constants;
  for (int i = 0; i < 20000; ++i) constants["k" + std::to_string(i)] = i;
  EXPECT_EQ(value("k19999 + a1", 1, 0, constants), 20000);  // in seconds, not minutes
}

TEST(Expression, WantsAValueForEachVariable) {
  EXPECT_THROW((void)Expression("1", {"a"})(std::array{1.0, 2.0}), Error);
}

TEST(Expression, MayBeEvaluatedByAnyThread) {
  const Expression square("a*a", {"a"});
  const auto wrong = [copy = square] {
    int count = 0;
    for (int i = 0; i < 20000; ++i) count += copy(std::array{double(i)}) != double(i) * i;
    return count;
  };
  int other = 1;
  std::thread thread([&] { other = wrong(); });
  EXPECT_EQ(wrong(), 0);
  thread.join();
  EXPECT_EQ(other, 0);
}

}  // namespace
}  // namespace deform
