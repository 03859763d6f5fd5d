#include "json/json_document.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>
#include <utility>

#include "json/json_pointer.h"

namespace deform {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

unsigned byte_at(std::string_view text, std::size_t at) {
  return at < text.size() ? static_cast<unsigned char>(text[at]) : 0U;
}

bool is_continuation(unsigned byte) { return (byte & 0xC0U) == 0x80U; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
char to_lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// What an unquoted word or a number, right or wrong, is made of.
bool is_word(char c) {
  return is_digit(c) || (to_lower(c) >= 'a' && to_lower(c) <= 'z') ||
         std::string_view("_$+-.").find(c) != std::string_view::npos;
}

/// Bytes of the code point that starts at `at`; 0 if it is not valid UTF-8.
std::size_t code_point_length(std::string_view text, std::size_t at) {
  const unsigned lead = byte_at(text, at);
  if (lead < 0x80) return 1;
  if (lead < 0xC2 || lead > 0xF4) return 0;
  const unsigned second = byte_at(text, at + 1);
  const bool overlong = (lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90);
  const bool surrogate = lead == 0xED && second > 0x9F;
  const bool too_large = lead == 0xF4 && second > 0x8F;
  if (overlong || surrogate || too_large) return 0;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  for (std::size_t i = 1; i < length; ++i) {
    if (!is_continuation(byte_at(text, at + i))) return 0;
  }
  return length;
}

/// The position of a byte, counted on from an earlier one whose position is known.
SourcePosition position_at(std::string_view text, std::size_t offset, std::size_t from = 0,
                           SourcePosition at = {1, 1}) {
  if (from == 0 && text.starts_with(kByteOrderMark)) from = kByteOrderMark.size();
  for (std::size_t i = from; i < offset; ++i) {
    if (text[i] == '\n' || (text[i] == '\r' && byte_at(text, i + 1) != '\n')) {
      at = {at.line + 1, 1};
    } else if (!is_continuation(byte_at(text, i))) {
      ++at.column;
    }
  }
  return at;
}

std::string hexadecimal(const char* format, unsigned number) {
  char digits[16];
  std::snprintf(digits, sizeof digits, format, number);
  return digits;
}

/// Text as a message shows it: in single quotes, on one line, not too long. A last code point that
/// was cut off is left away, so that the message is UTF-8 whatever the text.
std::string shown(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string out = "'";
  for (std::size_t i = 0, count = 0; i < text.size(); ++count) {
    if (count == kMost) return out + "...'";
    const std::size_t length = code_point_length(text, i);
    if (length == 0) break;
    const unsigned byte = byte_at(text, i);
    out += byte < 0x20 ? hexadecimal("\\u%04X", byte) : std::string(text.substr(i, length));
    i += length;
  }
  return out + "'";
}

/// A character as a message shows it. Beyond ASCII with its code point, for there are blanks and
/// quotes among those that look like the right ones.
std::string shown_character(std::string_view text, std::size_t at) {
  const std::size_t length = code_point_length(text, at);
  if (length == 1) return shown(text.substr(at, 1));
  unsigned code = byte_at(text, at) & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) code = code << 6U | (byte_at(text, at + i) & 0x3FU);
  return "'" + std::string(text.substr(at, length)) + "' " + hexadecimal("(U+%04X)", code);
}

std::string pointer_step(std::string_view key) {
  std::string step = "/";
  for (const char c : key) {
    if (c == '~')
      step += "~0";
    else if (c == '/')
      step += "~1";
    else
      step += c;
  }
  return step;
}

/// The rule of the JSON number grammar that `word` breaks; empty if it is a number.
std::string_view broken_number_rule(std::string_view word) {
  std::size_t i = 0;
  const auto skip_one_of = [&](std::string_view set) {
    const bool found = i < word.size() && set.find(word[i]) != std::string_view::npos;
    i += found ? 1 : 0;
    return found;
  };
  const auto skip_digits = [&] {
    const std::size_t start = i;
    while (i < word.size() && is_digit(word[i])) ++i;
    return i - start;
  };
  if (skip_one_of("+")) return "a number must not begin with '+'";
  skip_one_of("-");
  const std::size_t whole = i;
  const std::size_t digits = skip_digits();
  if (digits == 0) return "a number needs a digit before anything but a '-'";
  if (digits > 1 && word[whole] == '0') return "a number must not have leading zeros";
  if (skip_one_of(".") && skip_digits() == 0) return "a digit must follow the decimal point";
  if (skip_one_of("eE")) {
    skip_one_of("+-");
    if (skip_digits() == 0) return "a digit must follow the 'e' of a number";
  }
  return i == word.size() ? "" : "not a decimal number";
}

/// Thrown once a problem is noted behind which the text cannot be understood.
struct SyntaxError {};

/// Reads a text from front to back by recursive descent, which the depth limit keeps harmless.
class Reader {
 public:
  Reader(std::string_view text, std::vector<JsonDocument::Node>& nodes,
         std::vector<JsonProblem>& problems)
      : text_(text), nodes_(nodes), problems_(problems) {}

  Json document() {
    if (text_.size() > JsonDocument::kMaxBytes) {
      reject(0, "the text must not be larger than 16 MiB");
    }
    check_encoding();
    if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
    skip_blanks();
    if (at_end()) reject(at_, "the text is empty: it must hold a JSON value");
    Json root = value(JsonDocument::kNoKey);
    skip_blanks();
    if (!at_end()) {
      reject(at_,
             "nothing may follow the end of the JSON value, found " + shown_character(text_, at_));
    }
    return root;
  }

 private:
  /// An object or array whose end is not reached yet.
  struct Open {
    std::size_t at;
    char closer;
    std::string step;  // Of the JSON pointer, to the value being read; may be empty.
  };

  [[nodiscard]] bool at_end() const { return at_ == text_.size(); }
  [[nodiscard]] char peek() const { return at_end() ? '\0' : text_[at_]; }

  /// Counts on from what was located before, lest a hundred duplicates read a large text as often.
  SourcePosition locate(std::size_t at) {
    const auto& [from, known] = *std::prev(located_.upper_bound(at));
    return located_[at] = position_at(text_, at, from, known);
  }

  std::string place(std::size_t at) { return to_string(locate(at)); }

  [[nodiscard]] std::string pointer(std::size_t levels) const {
    std::string path;
    for (std::size_t i = 0; i < levels; ++i) path += open_[i].step;
    return path;
  }

  void note(std::size_t at, std::string message) {
    problems_.push_back({pointer(open_.size()), locate(at), std::move(message)});
  }

  [[noreturn]] void reject(std::size_t at, std::string message) {
    note(at, std::move(message));
    throw SyntaxError{};
  }

  [[noreturn]] void reject_end(const std::string& what) {
    constexpr std::size_t kMost = 4;
    std::string message = what + "the text ends too early";
    for (std::size_t i = open_.size(); i > 0; --i) {
      if (open_.size() - i == kMost) {
        message += ", and " + std::to_string(i) + " more";
        break;
      }
      const std::string path = pointer(i - 1);
      message += i == open_.size() ? "; still open: " : ", ";
      message += open_[i - 1].closer == '}' ? "the object " : "the array ";
      if (!path.empty()) message += shown(path) + " ";
      message += "begun at " + place(open_[i - 1].at);
    }
    reject(at_, message);
  }

  /// Encoding comes first, so that all else may rely on it.
  void check_encoding() {
    if (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF")) {
      reject(0, "the text must be UTF-8, found the byte order mark of UTF-16");
    }
    for (std::size_t i = 0, length = 0; i < text_.size(); i += length) {
      length = code_point_length(text_, i);
      if (length == 0) {
        reject(i, "the text must be UTF-8, found the byte " +
                      hexadecimal("0x%02X", byte_at(text_, i)) + " at byte offset " +
                      std::to_string(i));
      }
      if (text_[i] == '\0') {
        reject(i,
               "the text must not hold NUL bytes, found one at byte offset " + std::to_string(i));
      }
    }
  }

  void skip_blanks() {
    for (;; ++at_) {
      if (text_.substr(at_).starts_with("//")) {
        at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
      } else if (text_.substr(at_).starts_with("/*")) {
        reject(at_, "comments between /* and */ are not allowed: begin each line of one with //");
      } else if (peek() == '#') {
        reject(at_, "comments begin with //, found '#'");
      }
      if (at_end() || std::string_view(" \t\r\n").find(peek()) == std::string_view::npos) return;
    }
  }

  Json value(std::size_t key_at) {
    const std::size_t index = nodes_.size();
    nodes_.push_back({static_cast<std::uint32_t>(at_), static_cast<std::uint32_t>(key_at), 0});
    Json result = peek() == '{'   ? object()
                  : peek() == '[' ? array()
                  : peek() == '"' ? Json(string())
                                  : word();
    nodes_[index].next = static_cast<std::uint32_t>(nodes_.size());
    return result;
  }

  void open(char closer) {
    if (open_.size() == JsonDocument::kMaxDepth) {
      reject(at_, "objects and arrays must not nest deeper than " +
                      std::to_string(JsonDocument::kMaxDepth) + " levels, found one more " +
                      shown(text_.substr(at_, 1)));
    }
    open_.push_back({at_, closer, ""});
    ++at_;
    skip_blanks();
  }

  /// Whether the innermost open object or array ends here; steps over its end.
  bool closes() {
    if (at_end() || peek() != open_.back().closer) return false;
    ++at_;
    open_.pop_back();
    return true;
  }

  /// Steps over the comma behind an item; without one, closes() has to be true.
  void next_item() {
    open_.back().step.clear();
    const std::size_t item_end = at_;
    skip_blanks();
    if (at_end()) reject_end("");
    if (peek() == open_.back().closer) return;
    if (peek() != ',') {
      if (is_word(peek()) || std::string_view("\"'{[").find(peek()) != std::string_view::npos) {
        reject(item_end,
               "a ',' is missing before " + shown_character(text_, at_) + " at " + place(at_));
      }
      reject_unexpected("',' or '" + std::string(1, open_.back().closer) + "'");
    }
    const std::size_t comma = at_++;
    skip_blanks();
    if (peek() == '}' || peek() == ']') {
      reject(comma, "no trailing comma is allowed before " + shown(text_.substr(at_, 1)));
    }
    if (peek() == ',') reject(at_, "an item is missing between two commas");
  }

  [[noreturn]] void reject_unexpected(const std::string& expected) {
    if (at_end()) reject_end("expected " + expected + ", but ");
    if (peek() == '\'') reject(at_, "strings and keys need double quotes, found a single quote");
    std::string message = "expected " + expected + ", found " + shown_character(text_, at_);
    if ((peek() == '}' || peek() == ']') && !open_.empty() && peek() != open_.back().closer) {
      message += "; open is the " + std::string(open_.back().closer == '}' ? "object" : "array") +
                 " begun at " + place(open_.back().at);
    }
    reject(at_, message);
  }

  Json array() {
    Json result = Json::array();
    auto& items = result.get_ref<Json::array_t&>();
    for (open(']'); !closes(); next_item()) {
      open_.back().step = '/' + std::to_string(items.size());
      items.push_back(value(JsonDocument::kNoKey));
    }
    return result;
  }

  Json object() {
    // Members are collected here, and moved over at once: the ordered map searches all of its keys
    // at every insertion, and copies its values when it grows, which large objects cannot afford.
    std::vector<std::pair<std::string, Json>> members;
    std::map<std::string, std::size_t> seen;
    for (open('}'); !closes(); next_item()) {
      const std::size_t key_at = at_;
      std::string key = member_key();
      const auto [first, is_new] = seen.try_emplace(key, key_at);
      if (!is_new) note_duplicate(key, key_at, first->second);
      const std::size_t kept_nodes = nodes_.size();
      Json member = value(key_at);
      if (is_new)
        members.emplace_back(std::move(key), std::move(member));
      else
        nodes_.resize(kept_nodes);
    }
    Json result = Json::object();
    auto& object = result.get_ref<Json::object_t&>();
    object.reserve(members.size());
    for (auto& [key, member] : members) object.emplace_back(std::move(key), std::move(member));
    return result;
  }

  void note_duplicate(const std::string& key, std::size_t at, std::size_t first_at) {
    if (problems_.size() + 1 < JsonDocument::kMaxProblems) {
      note(at, "a key must appear only once in an object, found " + shown(key) +
                   " again; it is at " + place(first_at) + " already");
    } else if (problems_.size() + 1 == JsonDocument::kMaxProblems) {
      note(at, "the key " + shown(key) + " is a duplicate, too; further ones are not listed");
    }
  }

  /// Reads a key and its colon, up to the value.
  std::string member_key() {
    const std::size_t start = at_;
    if (is_word(peek())) reject(start, "a key needs double quotes, found " + shown(take_word()));
    if (peek() != '"') reject_unexpected("a key in double quotes");
    std::string key = string();
    if (key.size() > JsonDocument::kMaxKeyBytes) {
      reject(start, "a key must not be longer than " + std::to_string(JsonDocument::kMaxKeyBytes) +
                        " bytes, found " + shown(key));
    }
    open_.back().step = pointer_step(key);
    skip_blanks();
    if (peek() != ':') reject_unexpected("':' after the key " + shown(key));
    ++at_;
    skip_blanks();
    return key;
  }

  std::string_view take_word() {
    const std::size_t start = at_;
    while (is_word(peek())) ++at_;
    return text_.substr(start, at_ - start);
  }

  /// Reads what has no quotes or brackets: numbers, true, false and null.
  Json word() {
    const std::size_t start = at_;
    const std::string_view word = take_word();
    if (word.empty()) reject_unexpected("a value");
    if (word == "true" || word == "false") return Json(word == "true");
    if (word == "null") return Json(nullptr);
    std::string plain(word.substr(word[0] == '-' || word[0] == '+' ? 1 : 0));
    std::transform(plain.begin(), plain.end(), plain.begin(), to_lower);
    if (plain == "nan") reject(start, "JSON has no NaN, found " + shown(word));
    if (plain == "inf" || plain == "infinity") {
      reject(start, "JSON has no infinite numbers, found " + shown(word) +
                        "; where one is allowed, write \"infinity\" as a string");
    }
    if (plain == "true" || plain == "false" || plain == "null") {
      reject(start, "expected a value, found " + shown(word) + "; did you mean " + plain + "?");
    }
    if (is_digit(word[0]) || std::string_view("+-.").find(word[0]) != std::string_view::npos) {
      return number(start, word);
    }
    reject(start, "expected a value, found " + shown(word) + "; text needs double quotes");
  }

  Json number(std::size_t start, std::string_view word) {
    if (const auto rule = broken_number_rule(word); !rule.empty()) {
      reject(start, std::string(rule) + ", found " + shown(word));
    }
    const char* const end = word.data() + word.size();
    std::int64_t integer = 0;
    const auto whole = std::from_chars(word.data(), end, integer);
    if (whole.ec == std::errc() && whole.ptr == end) {
      // Unsigned where it can be, like the numbers the JSON library reads itself.
      return integer < 0 ? Json(integer) : Json(static_cast<std::uint64_t>(integer));
    }
    double real = 0;
    if (std::from_chars(word.data(), end, real).ec != std::errc()) {
      reject(start, "a number must be within the range of a double, found " + shown(word));
    }
    return Json(real);
  }

  std::string string() {
    const std::size_t start = at_++;
    std::string out;
    for (;;) {
      const std::size_t run = at_;
      while (!at_end() && peek() != '"' && peek() != '\\' && byte_at(text_, at_) >= 0x20) ++at_;
      out.append(text_.substr(run, at_ - run));
      if (at_end()) reject_end("the string begun at " + place(start) + " is not closed, ");
      if (peek() == '\\') {
        escape(out);
      } else if (peek() == '"') {
        ++at_;
        return out;
      } else if (peek() == '\n' || peek() == '\r') {
        reject(start, "a string must be closed on its line (or a line break in it written \\n): " +
                          shown(text_.substr(start, at_ - start)));
      } else {
        reject(at_, "a control character in a string must be written " +
                        hexadecimal("\\u%04X", byte_at(text_, at_)));
      }
    }
  }

  /// Reads an escape sequence and appends what it stands for.
  void escape(std::string& out) {
    constexpr std::string_view kLetters = "\"\\/bfnrt";
    constexpr std::string_view kMeanings = "\"\\/\b\f\n\r\t";
    const std::size_t start = at_++;
    if (at_end()) reject_end("a string is not closed, ");
    if (const auto i = kLetters.find(peek()); i != std::string_view::npos) {
      out += kMeanings[i];
      ++at_;
      return;
    }
    if (peek() != 'u') {
      reject(start,
             "a backslash must be followed by one of \"\\/bfnrtu (itself is written \\\\), "
             "found " +
                 shown_character(text_, at_));
    }
    unsigned code = code_unit(start);
    if (code >= 0xD800 && code <= 0xDBFF && text_.substr(at_).starts_with("\\u")) {
      ++at_;
      const unsigned low = code_unit(at_ - 1);
      if (low >= 0xDC00 && low <= 0xDFFF) code = 0x10000 + ((code - 0xD800) << 10U) + low - 0xDC00;
    }
    if (code >= 0xD800 && code <= 0xDFFF) {
      reject(start, "a surrogate must be one of a pair, high then low, found the lone " +
                        shown(text_.substr(start, 6)));
    }
    if (code == 0) reject(start, "a string must not hold \\u0000");
    append_utf8(out, code);
  }

  /// Reads the u and four hexadecimal digits of an escape sequence that began at `start`.
  unsigned code_unit(std::size_t start) {
    const std::string_view digits = text_.substr(++at_, 4);
    unsigned code = 0;
    const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), code, 16).ptr;
    if (end - digits.data() != 4) {
      reject(start, "\\u must be followed by four hexadecimal digits, found " + shown(digits));
    }
    at_ += 4;
    return code;
  }

  static void append_utf8(std::string& out, unsigned code) {
    const auto append = [&out](unsigned byte) { out += static_cast<char>(byte); };
    if (code < 0x80) return append(code);
    if (code >= 0x10000) append(0xF0U | code >> 18U);
    if (code >= 0x10000)
      append(0x80U | (code >> 12U & 0x3FU));
    else if (code >= 0x800)
      append(0xE0U | code >> 12U);
    append(code >= 0x800 ? 0x80U | (code >> 6U & 0x3FU) : 0xC0U | code >> 6U);
    append(0x80U | (code & 0x3FU));
  }

  std::string_view text_;
  std::vector<JsonDocument::Node>& nodes_;
  std::vector<JsonProblem>& problems_;
  std::vector<Open> open_;
  std::map<std::size_t, SourcePosition> located_{{0, {1, 1}}};
  std::size_t at_ = 0;
};

/// Whether a step of a JSON pointer is the index i, which has no leading zeros.
bool is_index(const std::string& step, std::size_t i) {
  char digits[24];
  const char* const end = std::to_chars(std::begin(digits), std::end(digits), i).ptr;
  return step == std::string_view(digits, static_cast<std::size_t>(end - digits));
}

/// The bytes of a file, or what kept them from being read. Of a file that is too large, enough is
/// returned to see that.
std::string file_text(const std::filesystem::path& file, std::string& trouble) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found)
    trouble = "the file does not exist";
  else if (error)
    trouble = "the file cannot be read: " + error.message();
  else if (is_directory(status))
    trouble = "a file is needed, found a folder";
  // Pipes and devices may never end, or never begin.
  else if (!is_regular_file(status))
    trouble = "a regular file is needed";
  if (!trouble.empty()) return "";

  std::ifstream in(file, std::ios::binary);
  const int cause = errno;
  std::string text;
  std::vector<char> block(std::size_t{1} << 16U);
  while (in && text.size() <= JsonDocument::kMaxBytes) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    text.append(block.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (!in.is_open())
    trouble = "the file cannot be read: " + std::generic_category().message(cause);
  else if (in.bad())
    trouble = "the file cannot be read to its end";
  return text;
}

}  // namespace

std::string to_string(SourcePosition position) {
  if (!position.known()) return "unknown position";
  return "line " + std::to_string(position.line) + ", column " + std::to_string(position.column);
}

JsonDocument JsonDocument::parse(std::string text, std::string name) {
  JsonDocument document;
  document.name_ = std::move(name);
  document.text_ = std::move(text);
  try {
    document.root_ = Reader(document.text_, document.nodes_, document.problems_).document();
  } catch (const SyntaxError&) {
    document.nodes_.clear();
  }
  return document;
}

JsonDocument JsonDocument::read(const std::filesystem::path& file) {
  std::string trouble;
  std::string text = file_text(file, trouble);
  if (trouble.empty()) return parse(std::move(text), file.string());
  JsonDocument document;
  document.name_ = file.string();
  document.problems_.push_back({"", {}, std::move(trouble)});
  return document;
}

const JsonDocument::Node* JsonDocument::find(std::string_view pointer) const {
  const auto steps = pointer_steps(pointer);
  if (!steps || nodes_.empty()) return nullptr;
  const Json* value = &root_;
  std::size_t node = 0;
  for (const std::string& step : *steps) {
    if (!value->is_structured()) return nullptr;
    std::size_t child_node = node + 1;
    auto child = value->begin();
    for (std::size_t i = 0; child != value->end(); ++child, ++i) {
      if (value->is_object() ? child.key() == step : is_index(step, i)) break;
      child_node = nodes_[child_node].next;
    }
    if (child == value->end()) return nullptr;
    value = &*child;
    node = child_node;
  }
  return &nodes_[node];
}

SourcePosition JsonDocument::position(std::string_view pointer) const {
  const Node* const node = find(pointer);
  return node == nullptr ? SourcePosition{} : position_at(text_, node->value_at);
}

SourcePosition JsonDocument::key_position(std::string_view pointer) const {
  const Node* const node = find(pointer);
  if (node == nullptr || node->key_at == kNoKey) return {};
  return position_at(text_, node->key_at);
}

}  // namespace deform
