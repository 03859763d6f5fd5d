#include "text/nearest_name.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace deform {
namespace {

const std::vector<std::string> kNames = {"gauss", "wave", "plane", "stiffness", "thickness"};

TEST(NearestName, FindsMistypedNames) {
  EXPECT_EQ(nearest_name("gaus", kNames), "gauss");    // missing letter
  EXPECT_EQ(nearest_name("gausss", kNames), "gauss");  // one too many
  EXPECT_EQ(nearest_name("gaoss", kNames), "gauss");   // wrong letter
  EXPECT_EQ(nearest_name("guasss", kNames), "gauss");  // swapped neighbours, one too many
  EXPECT_EQ(nearest_name("GAUSS", kNames), "gauss");   // case
  EXPECT_EQ(nearest_name("stifnes", kNames), "stiffness");
  EXPECT_EQ(nearest_name("wave", kNames), "wave");
}

TEST(NearestName, FindsNothingWhenNoneIsNear) {
  EXPECT_EQ(nearest_name("sphere", kNames), std::nullopt);
  EXPECT_EQ(nearest_name("", kNames), std::nullopt);
  EXPECT_EQ(nearest_name("gauss", {}), std::nullopt);
  EXPECT_EQ(nearest_name(std::string(100000, 'x'), kNames), std::nullopt);
}

TEST(NearestName, AllowsMoreEditsInLongerNames) {
  const std::vector<std::string> names = {"abcdefghijkl"};
  EXPECT_TRUE(nearest_name("abcdefghXXXX", names));   // 4 of 12
  EXPECT_FALSE(nearest_name("abcdefgXXXXX", names));  // 5 of 12
  EXPECT_FALSE(nearest_name("abcdefghXXX", names));   // 4 of 11
}

TEST(NearestName, CountsASwapAsOneEdit) {
  const std::vector<std::string> names = {"abcd"};
  EXPECT_TRUE(nearest_name("badc", names));  // two swaps
  EXPECT_FALSE(nearest_name("dcba", names));
}

TEST(NearestName, DoesNotReplaceAllOfAShortName) {
  const std::vector<std::string> names = {"kd", "ab"};
  EXPECT_EQ(nearest_name("xy", names), std::nullopt);
  EXPECT_EQ(nearest_name("ks", names), "kd");
}

TEST(NearestName, TakesTheNearestAndOfEqualsTheFirst) {
  const std::vector<std::string> names = {"abxx", "abcx", "abcy"};
  EXPECT_EQ(nearest_name("abcd", names), "abcx");
}

TEST(DidYouMean, SuggestsOrLists) {
  EXPECT_EQ(did_you_mean("gaus", kNames), "; did you mean \"gauss\"?");
  EXPECT_EQ(did_you_mean("sphere", std::vector<std::string>{"gauss", "wave"}),
            "; valid are \"gauss\", \"wave\"");
  EXPECT_EQ(did_you_mean("sphere", std::vector<std::string>{"gauss"}), "; valid is \"gauss\"");
  EXPECT_EQ(did_you_mean("sphere", {}), "");
}

TEST(DidYouMean, ListsAtMostTwelveNames) {
  std::vector<std::string> names;
  for (char c = 'a'; c < 'a' + 12; ++c) names.emplace_back(10, c);
  EXPECT_NE(did_you_mean("sphere", names), "");
  names.emplace_back("one too many");
  EXPECT_EQ(did_you_mean("sphere", names), "");
}

}  // namespace
}  // namespace deform
