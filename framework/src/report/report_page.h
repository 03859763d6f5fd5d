/// The page that reports are made from: report.html without data.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace deform {

/// What stands around the data: docs/report-format.md.
class ReportPage {
 public:
  /// Throws InputError when the text does not have exactly one place for the data.
  explicit ReportPage(std::string text);

  /// With the element's opening tag as its end.
  [[nodiscard]] std::string_view before() const;
  /// With the element's closing tag as its beginning.
  [[nodiscard]] std::string_view after() const;
  [[nodiscard]] std::size_t bytes() const { return text_.size(); }

 private:
  std::string text_;
  std::size_t data_at_ = 0;
};

/// Appends JSON text so that it cannot end the element it stands in: `<`, which is only in strings,
/// as \u003c.
void append_escaped(std::string& text, std::string_view json);

}  // namespace deform
