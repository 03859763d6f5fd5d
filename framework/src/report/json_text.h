#pragma once

#include <string>
#include <string_view>

#include "json/json.h"
#include "report/report_page.h"

namespace deform {

/// Writes JSON text piece by piece: a whole report as a value in memory would take several times
/// the room of its text. Escapes as append_escaped does.
class JsonText {
 public:
  explicit JsonText(std::string& text) : text_(text) {}

  void begin(char bracket) {
    separate();
    text_ += bracket;
    first_ = true;
  }
  void end(char bracket) {
    text_ += bracket;
    first_ = false;
  }
  void key(std::string_view name) {
    separate();
    text_ += '"';
    text_ += name;
    text_ += "\":";
    first_ = true;  // no comma before the value
  }
  void value(const Json& value) {
    separate();
    append_escaped(text_, value.dump(-1, ' ', false, Json::error_handler_t::replace));
  }
  void member(std::string_view name, const Json& value) {
    key(name);
    this->value(value);
  }
  /// A value that `write(text)` appends as JSON without any `<`.
  template <class Write>
  void raw(const Write& write) {
    separate();
    write(text_);
  }
  /// A string that `write(text)` appends, of characters that JSON takes as they are.
  template <class Write>
  void text(const Write& write) {
    raw([&write](std::string& text) {
      text += '"';
      write(text);
      text += '"';
    });
  }

 private:
  void separate() {
    if (!first_) text_ += ',';
    first_ = false;
  }

  std::string& text_;
  bool first_ = true;
};

}  // namespace deform
