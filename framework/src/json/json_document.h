#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "json/json.h"

namespace deform {

/// A place in a text. Lines and columns count from 1, columns in Unicode code points; 0 is unknown.
/// A line ends at LF, CR LF or a lone CR; a byte order mark takes no column.
struct SourcePosition {
  std::size_t line = 0;
  std::size_t column = 0;

  [[nodiscard]] bool known() const { return line != 0; }
  bool operator==(const SourcePosition&) const = default;
};

/// "line 3, column 7", or "unknown position".
std::string to_string(SourcePosition position);

/// Something wrong with a JSON text.
struct JsonProblem {
  std::string pointer;  ///< JSON pointer (RFC 6901) of the value being read; "" is the whole text.
  SourcePosition at;    ///< Unknown if the file could not be read.
  std::string message;  ///< The rule that was broken, with the offending text; one line.
};

/// A JSON text together with where each of its values stands.
///
/// Accepts strict JSON (RFC 8259) in UTF-8, plus `//` comments and a leading byte order mark. The
/// text may have 16 MiB, 64 nested levels and keys of 1024 bytes; keys are unique in their object,
/// and a string holds no U+0000, which would cut it short in C interfaces. Integers that fit int64
/// stay exact, larger ones become doubles; a number no double can hold is a problem.
class JsonDocument {
 public:
  static constexpr std::size_t kMaxBytes = std::size_t{16} << 20U;
  static constexpr std::size_t kMaxDepth = 64;
  static constexpr std::size_t kMaxKeyBytes = 1024;
  static constexpr std::size_t kMaxProblems = 100;

  /// Parses `text`; `name` is what messages call it. Does not throw on bad text: see problems().
  static JsonDocument parse(std::string text, std::string name);

  /// Reads and parses a regular file. One that cannot be read is reported in problems(), too.
  static JsonDocument read(const std::filesystem::path& file);

  /// The value read. Null after a syntax error; of a duplicate key the first value is kept.
  [[nodiscard]] const Json& root() const { return root_; }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::size_t bytes() const { return text_.size(); }

  /// Empty if the text is fine. All duplicate keys (up to kMaxProblems), then the syntax error that
  /// ended the parse, if any.
  [[nodiscard]] const std::vector<JsonProblem>& problems() const { return problems_; }

  /// Where the value at a JSON pointer starts; unknown if there is none. Takes time linear in the
  /// text: made for messages.
  [[nodiscard]] SourcePosition position(std::string_view pointer) const;

  /// Where the key of the object member at a JSON pointer starts; unknown if it is not a member.
  [[nodiscard]] SourcePosition key_position(std::string_view pointer) const;

  /// Where a value was found. All values stand in one list in the order of the text, each followed
  /// by its descendants: 12 bytes a value, where a map from pointers would outgrow the text.
  struct Node {
    std::uint32_t value_at;  ///< Byte offset.
    std::uint32_t key_at;    ///< Byte offset, or kNoKey.
    std::uint32_t next;      ///< Index of the first node that is not a descendant.
  };
  static constexpr std::uint32_t kNoKey = 0xFFFFFFFF;

 private:
  [[nodiscard]] const Node* find(std::string_view pointer) const;

  std::string name_;
  std::string text_;
  Json root_;
  std::vector<Node> nodes_;
  std::vector<JsonProblem> problems_;
};

}  // namespace deform
