/// Formulas that a scene gives as text, evaluated for named variables.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "deform/error.h"
#include "deform/export.h"

namespace deform {

/// A text that is no formula; `why` without the text itself, and the name or sign that is wrong
/// ("" where it is not a single one).
class DEFORM_API ExpressionError : public InputError {
 public:
  ExpressionError(const std::string& message, std::string why, std::string token);
  ~ExpressionError() override;
  [[nodiscard]] const std::string& why() const noexcept { return why_; }
  [[nodiscard]] const std::string& token() const noexcept { return token_; }

 private:
  std::string why_, token_;
};

/// A formula: + - * / ^, comparisons, && and ||, c ? a : b, sin cos tan asin acos atan atan2 sinh
/// cosh tanh exp ln log10 sqrt abs sign rint min max sum avg …, the number pi, the constants and
/// the variables. Copies share it. Any thread may evaluate it, but one at a time: do so when an
/// object is made, not in its steps.
class DEFORM_API Expression {
 public:
  using Constants = std::map<std::string, double>;

  /// Throws ExpressionError when the text is not one formula of these variables and constants, and
  /// when a constant has the name of something else, or none that a formula could use.
  Expression(std::string text, std::vector<std::string> variables, const Constants& constants = {});

  [[nodiscard]] const std::string& text() const;
  /// The value for values of the variables, in the order in which these were named. It need not be
  /// finite: 1/0 is infinite, sqrt(-1) is NaN. Throws Error when there are not as many values as
  /// variables.
  [[nodiscard]] double operator()(std::span<const double> values) const;

 private:
  struct Parsed;
  std::shared_ptr<Parsed> parsed_;
};

}  // namespace deform
