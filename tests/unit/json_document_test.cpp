#include "json/json_document.h"

#include <filesystem>
#include <fstream>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

// Texts escape alike here, whether or not the odd one could be a raw string.
// NOLINTBEGIN(modernize-raw-string-literal)

namespace deform {
namespace {

JsonDocument parse(std::string text) { return JsonDocument::parse(std::move(text), "scene.json"); }

std::string repeated(const std::string& text, std::size_t times) {
  std::string out;
  for (std::size_t i = 0; i < times; ++i) out += text;
  return out;
}

TEST(JsonDocument, ReadsAllKindsOfValues) {
  const auto document = parse(R"({
    "null": null, "yes": true, "no": false,  // a comment
    "text": "a\"\\\/\b\f\n\r\tz", "unicode": "\u0041\u00e4\u20AC\ud83d\ude00",
    "empty": [{}, [], ""], "numbers": [0, -0, 1, -12, 0.5, 1e3, -2.5E-1]
  } // the end)");
  ASSERT_TRUE(document.problems().empty()) << document.problems()[0].message;
  const Json& root = document.root();
  EXPECT_EQ(document.name(), "scene.json");
  EXPECT_TRUE(root["null"].is_null());
  EXPECT_EQ(root["yes"], true);
  EXPECT_EQ(root["no"], false);
  EXPECT_EQ(root["text"], "a\"\\/\b\f\n\r\tz");
  EXPECT_EQ(root["unicode"], "A\u00e4\u20AC\U0001F600");
  EXPECT_EQ(root["empty"].dump(), "[{},[],\"\"]");
  EXPECT_EQ(root["numbers"].dump(), "[0,0,1,-12,0.5,1000.0,-0.25]");
}

TEST(JsonDocument, AgreesWithTheLibraryOnValidText) {
  const std::string text =
      R"([1, -1, 9223372036854775807, -9223372036854775808, 0.1, 1e-310, 1.7976931348623157e308,
          {"b": {"~/": "\\u"}, "a": [[]]}, "ä\u00df"])";
  const auto document = parse(text);
  ASSERT_TRUE(document.problems().empty()) << document.problems()[0].message;
  EXPECT_EQ(document.root(), Json::parse(text));
  EXPECT_TRUE(document.root()[0].is_number_unsigned());
  EXPECT_TRUE(document.root()[1].is_number_integer());
}

TEST(JsonDocument, KeepsTheOrderOfKeys) {
  EXPECT_EQ(parse(R"({"z": 1, "a": 2, "m": 3})").root().dump(), R"({"z":1,"a":2,"m":3})");
}

TEST(JsonDocument, MakesIntegersBeyondInt64Doubles) {
  const auto document = parse("[9223372036854775807, 9223372036854775808, -9223372036854775809]");
  const Json& root = document.root();
  EXPECT_EQ(root[0].get<std::int64_t>(), std::numeric_limits<std::int64_t>::max());
  EXPECT_TRUE(root[0].is_number_integer());
  EXPECT_TRUE(root[1].is_number_float());
  EXPECT_DOUBLE_EQ(root[1].get<double>(), 9223372036854775808.0);
  EXPECT_TRUE(root[2].is_number_float());
}

TEST(JsonDocument, FindsPositions) {
  const auto document =
      parse("{\r\n  \"a\": [1,\n 2, {\"x/y~\": \"ä\", \"é€😀\": -3}],\r \"\": {}\n}");
  ASSERT_TRUE(document.problems().empty());
  const auto at = [&](const char* pointer) { return document.position(pointer); };
  const auto key_at = [&](const char* pointer) { return document.key_position(pointer); };
  EXPECT_EQ(at(""), (SourcePosition{1, 1}));
  EXPECT_EQ(at("/a"), (SourcePosition{2, 8}));
  EXPECT_EQ(key_at("/a"), (SourcePosition{2, 3}));
  EXPECT_EQ(at("/a/0"), (SourcePosition{2, 9}));
  EXPECT_EQ(at("/a/1"), (SourcePosition{3, 2}));
  EXPECT_EQ(at("/a/2"), (SourcePosition{3, 5}));
  EXPECT_EQ(key_at("/a/2/x~1y~0"), (SourcePosition{3, 6}));
  EXPECT_EQ(key_at("/a/2/é€😀"), (SourcePosition{3, 19}));
  EXPECT_EQ(at("/a/2/é€😀"), (SourcePosition{3, 26}));
  EXPECT_EQ(at("/"), (SourcePosition{4, 6}));
  EXPECT_EQ(key_at("/"), (SourcePosition{4, 2}));
}

TEST(JsonDocument, PositionsOfWhatIsNotThereAreUnknown) {
  const auto document = parse(R"({"a": [1, "x"], "ab": 2})");
  for (const char* pointer : {"a", "/b", "/a/2", "/a/-", "/a/00", "/a/+1", "/a/1/0", "/a/", "/ab/",
                              "/A", "/a~1", "/a~", "//", "/a/18446744073709551616"}) {
    EXPECT_FALSE(document.position(pointer).known()) << pointer;
    EXPECT_FALSE(document.key_position(pointer).known()) << pointer;
  }
  EXPECT_FALSE(document.key_position("").known());
  EXPECT_FALSE(document.key_position("/a/0").known());
  EXPECT_EQ(to_string(document.position("/b")), "unknown position");
  EXPECT_EQ(to_string(document.position("/ab")), "line 1, column 23");
  EXPECT_FALSE(JsonDocument().position("").known());
}

TEST(JsonDocument, SkipsAByteOrderMark) {
  const auto document = parse("\xEF\xBB\xBF{\"a\": 1}");
  ASSERT_TRUE(document.problems().empty());
  EXPECT_EQ(document.position(""), (SourcePosition{1, 1}));
  EXPECT_EQ(document.position("/a"), (SourcePosition{1, 7}));
  EXPECT_FALSE(parse("\xEF\xBB\xBF\xEF\xBB\xBF 1").problems().empty());
}

TEST(JsonDocument, ReportsAllDuplicateKeysAndKeepsTheFirst) {
  const auto document =
      parse("{\"a\": 1,\n \"a\": {\"x\": 1, \"x\": [2]}, \"b\": [3],\n \"b\": 4, \"c\": 5}");
  const auto& problems = document.problems();
  ASSERT_EQ(problems.size(), 3U);
  EXPECT_EQ(problems[0].pointer, "/a");
  EXPECT_EQ(problems[0].at, (SourcePosition{2, 2}));
  EXPECT_NE(problems[0].message.find("'a' again; it is at line 1, column 2"), std::string::npos)
      << problems[0].message;
  EXPECT_EQ(problems[1].pointer, "/a/x");
  EXPECT_EQ(problems[2].pointer, "/b");
  EXPECT_EQ(document.root().dump(), R"({"a":1,"b":[3],"c":5})");
  EXPECT_EQ(document.position("/b/0"), (SourcePosition{2, 33}));
  EXPECT_EQ(document.position("/c"), (SourcePosition{3, 15}));
}

TEST(JsonDocument, ReportsDuplicateKeysAlongWithASyntaxError) {
  const auto document = parse("{\"a\": 1, \"a\": 2, }");
  ASSERT_EQ(document.problems().size(), 2U);
  EXPECT_EQ(document.problems()[1].at, (SourcePosition{1, 16}));
  EXPECT_TRUE(document.root().is_null());
  EXPECT_FALSE(document.position("").known());
}

TEST(JsonDocument, SameKeyWrittenInTwoWaysIsADuplicate) {
  EXPECT_EQ(parse(R"({"a": 1, "\u0061": 2})").problems().size(), 1U);
}

TEST(JsonDocument, ListsALimitedNumberOfDuplicates) {
  const auto document = parse("{\"a\": 1" + repeated(", \"a\": 1", 5000) + "}");
  EXPECT_EQ(document.problems().size(), JsonDocument::kMaxProblems);
  EXPECT_NE(document.problems().back().message.find("not listed"), std::string::npos);
}

struct Bad {
  std::string text;
  SourcePosition at;
  std::string pointer;
  std::string part;  // Of the message.
};

std::ostream& operator<<(std::ostream& out, const Bad& bad) {
  return out << testing::PrintToString(bad.text);
}

class JsonDocumentSyntax : public testing::TestWithParam<Bad> {};

TEST_P(JsonDocumentSyntax, IsReported) {
  const Bad& bad = GetParam();
  const auto document = parse(bad.text);
  ASSERT_EQ(document.problems().size(), 1U);
  const JsonProblem& problem = document.problems()[0];
  EXPECT_EQ(problem.at, bad.at) << to_string(problem.at) << ": " << problem.message;
  EXPECT_EQ(problem.pointer, bad.pointer);
  EXPECT_NE(problem.message.find(bad.part), std::string::npos) << problem.message;
  EXPECT_EQ(problem.message.find('\n'), std::string::npos);
  EXPECT_TRUE(document.root().is_null());
}

const std::vector<Bad> kStructure = {
    {"", {1, 1}, "", "the text is empty"},
    {" // only this", {1, 14}, "", "the text is empty"},
    {"{\"a\": 1,\n}", {1, 8}, "", "no trailing comma is allowed before '}'"},
    {"[1, 2,]", {1, 6}, "", "no trailing comma is allowed before ']'"},
    {"[1,,2]", {1, 4}, "", "an item is missing between two commas"},
    {"[,1]", {1, 2}, "/0", "expected a value, found ','"},
    {"{\"a\": 1\n \"b\": 2}", {1, 8}, "", "a ',' is missing before '\"' at line 2, column 2"},
    {"[[1] [2]]", {1, 5}, "", "a ',' is missing before '['"},
    {"[1 2]", {1, 3}, "", "a ',' is missing before '2'"},
    {"[1; 2]", {1, 3}, "", "expected ',' or ']', found ';'"},
    {"{\"a\" 1}", {1, 6}, "/a", "expected ':' after the key 'a', found '1'"},
    {"{\"a\" = 1}", {1, 6}, "/a", "expected ':' after the key 'a', found '='"},
    {"{\"a\": }", {1, 7}, "/a", "expected a value, found '}'"},
    {"{\"a\": [1}", {1, 9}, "/a", "found '}'; open is the array begun at line 1, column 7"},
    {"{1: 2}", {1, 2}, "", "a key needs double quotes, found '1'"},
    {"{name: 2}", {1, 2}, "", "a key needs double quotes, found 'name'"},
    {"{\"a\": {'b': 2}}", {1, 8}, "/a", "double quotes"},
    {"['a']", {1, 2}, "/0", "double quotes"},
    {"{\"a/b\": [0, gauss]}", {1, 13}, "/a~1b/1", "found 'gauss'; text needs double quotes"},
    {"{}\n{}", {2, 1}, "", "nothing may follow the end of the JSON value, found '{'"},
    {"1 x", {1, 3}, "", "nothing may follow"},
    {"/* no */ 1", {1, 1}, "", "comments between /* and */"},
    {"[1, # no\n2]", {1, 5}, "", "comments begin with //"},
    {"[1, / 2]", {1, 5}, "/1", "expected a value, found '/'"},
    {"[\u00a01]", {1, 2}, "/0", "(U+00A0)"},
    {"[\u201ca\u201d]", {1, 2}, "/0", "(U+201C)"},
    {"\"é\" 😀", {1, 5}, "", "(U+1F600)"},
};

const std::vector<Bad> kTruncated = {
    {"{\"a\":\n [{\"b\": 1, ",
     {2, 12},
     "/a/0",
     "still open: the object '/a/0' begun at line 2, column 3, the array '/a' begun at line 2, "
     "column 2, the object begun at line 1, column 1"},
    {"[1", {1, 3}, "", "the text ends too early; still open: the array begun at line 1, column 1"},
    {"{", {1, 2}, "", "expected a key in double quotes, but the text ends too early"},
    {"{\"a\"", {1, 5}, "/a", "expected ':'"},
    {"{\"a\":", {1, 6}, "/a", "expected a value, but the text ends too early"},
    {"[\"ab", {1, 5}, "/0", "the string begun at line 1, column 2 is not closed"},
    {"\"", {1, 2}, "", "is not closed"},
    {"\"\\", {1, 3}, "", "is not closed"},
    {"[[[[[[", {1, 7}, "/0/0/0/0/0/0", ", and 2 more"},
};

const std::vector<Bad> kWords = {
    {"[NaN]", {1, 2}, "/0", "JSON has no NaN, found 'NaN'"},
    {"[-Infinity]", {1, 2}, "/0", "found '-Infinity'; where one is allowed, write \"infinity\""},
    {"inf", {1, 1}, "", "\"infinity\" as a string"},
    {"True", {1, 1}, "", "did you mean true?"},
    {"nul", {1, 1}, "", "found 'nul'"},
    {"+1", {1, 1}, "", "must not begin with '+'"},
    {"01", {1, 1}, "", "leading zeros, found '01'"},
    {"-", {1, 1}, "", "needs a digit"},
    {".5", {1, 1}, "", "needs a digit"},
    {"[1, 5.]", {1, 5}, "/1", "a digit must follow the decimal point, found '5.'"},
    {"1e+", {1, 1}, "", "a digit must follow the 'e'"},
    {"0x1F", {1, 1}, "", "not a decimal number, found '0x1F'"},
    {"1.5mm", {1, 1}, "", "not a decimal number, found '1.5mm'"},
    {"[1, 1e999]", {1, 5}, "/1", "within the range of a double, found '1e999'"},
    {"-1e999", {1, 1}, "", "within the range of a double"},
    {"1e-999", {1, 1}, "", "within the range of a double"},
    {repeated("9", 1000), {1, 1}, "", "found '" + repeated("9", 40) + "...'"},
};

const std::vector<Bad> kStrings = {
    {"\"a\tb\"", {1, 3}, "", "must be written \\u0009"},
    {"[\n\"ab\n\"]", {2, 1}, "/0", "must be closed on its line"},
    {"\"a\\qb\"", {1, 3}, "", "found 'q'"},
    {"\"\\u12g4\"", {1, 2}, "", "four hexadecimal digits, found '12g4'"},
    {"\"\\u12€34\"", {1, 2}, "", "found '12'"},  // Not half of a code point.
    {"\"\\u-123\"", {1, 2}, "", "four hexadecimal digits"},
    {"\"\\u12", {1, 2}, "", "four hexadecimal digits"},
    {"\"\\u", {1, 2}, "", "four hexadecimal digits"},
    {"\"\\ud800\"", {1, 2}, "", "found the lone '\\ud800'"},
    {"\"\\udc00\"", {1, 2}, "", "found the lone '\\udc00'"},
    {"\"\\ud800\\u0041\"", {1, 2}, "", "found the lone '\\ud800'"},
    {"\"\\ud800\\u", {1, 8}, "", "four hexadecimal digits"},
    {"\"a\\u0000\"", {1, 3}, "", "\\u0000"},
    {"{\"" + repeated("k", 1025) + "\": 1}", {1, 2}, "", "not be longer than 1024 bytes"},
};

const std::vector<Bad> kEncoding = {
    {"[\"é\xFF\"]", {1, 4}, "", "the byte 0xFF at byte offset 4"},
    {"\n\xC3", {2, 1}, "", "the byte 0xC3 at byte offset 1"},
    {"\"\xC0\x80\"", {1, 2}, "", "0xC0"},
    {"\"\xE0\x80\x80\"", {1, 2}, "", "0xE0"},
    {"\"\xED\xA0\x80\"", {1, 2}, "", "0xED"},
    {"\"\xF4\x90\x80\x80\"", {1, 2}, "", "0xF4"},
    {"\"\x80\"", {1, 2}, "", "0x80"},
    {"\xFF\xFE{", {1, 1}, "", "UTF-16"},
    {std::string("{\"a\": \0 1}", 10), {1, 7}, "", "NUL bytes, found one at byte offset 6"},
};

INSTANTIATE_TEST_SUITE_P(Structure, JsonDocumentSyntax, testing::ValuesIn(kStructure));
INSTANTIATE_TEST_SUITE_P(Truncated, JsonDocumentSyntax, testing::ValuesIn(kTruncated));
INSTANTIATE_TEST_SUITE_P(Words, JsonDocumentSyntax, testing::ValuesIn(kWords));
INSTANTIATE_TEST_SUITE_P(Strings, JsonDocumentSyntax, testing::ValuesIn(kStrings));
INSTANTIATE_TEST_SUITE_P(Encoding, JsonDocumentSyntax, testing::ValuesIn(kEncoding));

TEST(JsonDocument, LimitsTheDepth) {
  EXPECT_TRUE(parse(repeated("[", 64) + repeated("]", 64)).problems().empty());
  for (const std::string& text : {repeated("[", 65) + repeated("]", 65), repeated("[", 1000000),
                                  repeated("{\"a\":", 1000000)}) {
    const auto document = parse(text);
    ASSERT_EQ(document.problems().size(), 1U);
    EXPECT_NE(document.problems()[0].message.find("deeper than 64 levels"), std::string::npos);
  }
}

TEST(JsonDocument, EveryPrefixOfASceneIsReportedAsOneProblem) {
  const std::string scene = R"({"a": [1.5, "x\u00e4", {"b": null}], "c": {"d": true}})";
  for (std::size_t length = 0; length < scene.size(); ++length) {
    EXPECT_EQ(parse(scene.substr(0, length)).problems().size(), 1U) << scene.substr(0, length);
  }
}

TEST(JsonDocument, ReadsLargeObjectsInGoodTime) {
  std::string text = "{\"first\": 0";
  for (int i = 0; i < 100000; ++i) text += ",\"" + std::to_string(i) + "\": [1]";
  const auto document = parse(text + "}");  // Quadratic time would show as a minute.
  EXPECT_TRUE(document.problems().empty());
  EXPECT_EQ(document.root().size(), 100001U);
  EXPECT_TRUE(document.position("/99999/0").known());
}

class JsonDocumentFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
    const std::string name = std::string("json_document_") + test->name();
    folder_ = std::filesystem::path(testing::TempDir()) / name;
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string problem_of(const std::filesystem::path& file) const {
    const auto document = JsonDocument::read(file);
    EXPECT_EQ(document.name(), file.string());
    EXPECT_TRUE(document.root().is_null());
    EXPECT_EQ(document.problems().size(), 1U);
    return document.problems().empty() ? "" : document.problems()[0].message;
  }

  std::filesystem::path folder_;
};

TEST_F(JsonDocumentFile, IsRead) {
  const auto file = folder_ / "scene.json";
  std::ofstream(file, std::ios::binary) << "{\r\n\"a\": 1}";
  const auto document = JsonDocument::read(file);
  EXPECT_TRUE(document.problems().empty());
  EXPECT_EQ(document.root()["a"], 1);
  EXPECT_EQ(document.position("/a"), (SourcePosition{2, 6}));
}

TEST_F(JsonDocumentFile, ThatCannotBeReadIsAProblem) {
  EXPECT_EQ(problem_of(folder_ / "none.json"), "the file does not exist");
  EXPECT_EQ(problem_of(""), "the file does not exist");
  EXPECT_EQ(problem_of(folder_), "a file is needed, found a folder");
  EXPECT_NE(problem_of(folder_ / repeated("x", 5000)).find("cannot be read"), std::string::npos);
  if (std::filesystem::exists("/dev/zero")) {
    EXPECT_EQ(problem_of("/dev/zero"), "a regular file is needed");
  }
}

TEST_F(JsonDocumentFile, ThatIsEmptyIsAProblem) {
  std::ofstream(folder_ / "empty.json").close();
  EXPECT_NE(problem_of(folder_ / "empty.json").find("is empty"), std::string::npos);
}

TEST_F(JsonDocumentFile, ThatIsTooLargeIsAProblem) {
  const auto file = folder_ / "large.json";
  std::ofstream(file).close();
  std::filesystem::resize_file(file, JsonDocument::kMaxBytes + 1);
  EXPECT_EQ(problem_of(file), "the text must not be larger than 16 MiB");
}

}  // namespace
}  // namespace deform

// NOLINTEND(modernize-raw-string-literal)
