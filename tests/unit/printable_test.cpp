#include "deform/printable.h"

#include <gtest/gtest.h>

namespace deform {
namespace {

TEST(Printable, LeavesTextsAsTheyAre) {
  for (const char* text : {"", "plain", "Grüße, 纸, r_11 ≥ 0 — \\ \"q\"", "\xF0\x9F\x93\x84"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, ShowsWhatTerminalsTakeForOrders) {
  EXPECT_EQ(printable("a\x1b[2Jb"), "a\\u001b[2Jb");
  EXPECT_EQ(printable("one\ntwo\tthree\r"), "one\\ntwo\\tthree\\r");
  EXPECT_EQ(printable(std::string_view("\0", 1)), "\\u0000");
  EXPECT_EQ(printable("\x7f"), "\\u007f");
  EXPECT_EQ(printable("\xC2\x9b"
                      "31m"),
            "\\u009b31m");  // C1's CSI, as UTF-8 …
  EXPECT_EQ(printable("\x9b"
                      "31m"),
            "\\x9b31m");  // … and as a byte
}

TEST(Printable, ShowsWhatIsNotSeen) {
  EXPECT_EQ(printable("a\u202Eb\u2066c\u200Bd\u2028e"), "a\\u202eb\\u2066c\\u200bd\\u2028e");
  EXPECT_EQ(printable("\U000E0041"), "\\udb40\\udc41");
}

TEST(Printable, ShowsBytesThatAreNoUtf8) {
  EXPECT_EQ(printable("\xFF"), "\\xff");
  EXPECT_EQ(printable("\xC0\xAF"), "\\xc0\\xaf");                    // longer than need be
  EXPECT_EQ(printable("\xE2\x80"), "\\xe2\\x80");                    // cut off
  EXPECT_EQ(printable("\xF4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond Unicode
}

}  // namespace
}  // namespace deform
