#include "profile/profile.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace deform {
namespace {

using Json = nlohmann::json;

/// Complete events of the trace.
std::vector<Json> spans_of(const Profile& profile) {
  std::vector<Json> spans;
  const Json trace = Json::parse(profile.trace());
  for (const Json& event : trace["traceEvents"])
    if (event["ph"] == "X") spans.push_back(event);
  return spans;
}

TEST(Profile, RecordsNothingUnlessActive) {
  Profile profile;
  { const Span span("before"); }
  {
    const Profile::Active active(&profile);
    const Span span("within");
  }
  { const Span span("after"); }
  ASSERT_EQ(spans_of(profile).size(), 1U);
  EXPECT_EQ(spans_of(profile)[0]["name"], "within");
}

TEST(Profile, DropsTheOldestSpansAndSaysSo) {
  Profile profile(3);
  {
    const Profile::Active active(&profile);
    for (const char* part : {"a", "b", "c", "d", "e"}) const Span span(part);
  }
  const std::vector<Json> spans = spans_of(profile);
  ASSERT_EQ(spans.size(), 3U);
  for (const Json& span : spans) EXPECT_GE(span["name"], "c");
  EXPECT_EQ(Json::parse(profile.trace())["otherData"]["dropped_spans"], 2);
  EXPECT_NE(profile.table().find("the last 3 spans; 2 before them were dropped"),
            std::string::npos);
  EXPECT_NE(profile.table().find("\na "), std::string::npos) << "the table has them all";
}

TEST(Profile, EndsSpansThatAnExceptionLeaves) {
  Profile profile;
  const Profile::Active active(&profile);
  try {
    const Span outer("outer");
    const Span inner("inner");
    throw 0;
  } catch (int) {
  }
  { const Span span("next"); }
  EXPECT_NE(profile.table().find("\n  inner "), std::string::npos);
  EXPECT_NE(profile.table().find("\nnext "), std::string::npos);
}

TEST(Profile, NamesNeedEscapes) {
  Profile profile;
  const Profile::Active active(&profile);
  { const Span span("a \"b\"\n"); }
  EXPECT_EQ(spans_of(profile).at(0)["name"], "a \"b\"\n");
}

}  // namespace
}  // namespace deform
