#include "deform/plugin/field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/plugin/expression.h"
#include "deform/plugin/number_file.h"

#include "plugin/parameter_text.h"

namespace deform {
namespace {

/// Values in rows along a1, one row above the other along a2.
struct Grid {
  std::size_t columns = 0, rows = 0;
  std::vector<double> values;

  [[nodiscard]] double at(const Vec2& parameter, const ParameterRectangle& within) const {
    const auto [i, u] = cell(parameter[0], within.lower[0], within.upper[0], columns);
    const auto [j, v] = cell(parameter[1], within.lower[1], within.upper[1], rows);
    const auto value = [this](std::size_t column, std::size_t row) {
      return values[std::min(row, rows - 1) * columns + std::min(column, columns - 1)];
    };
    return (1 - v) * ((1 - u) * value(i, j) + u * value(i + 1, j)) +
           v * ((1 - u) * value(i, j + 1) + u * value(i + 1, j + 1));
  }

 private:
  /// The cell between two of `count` values in which a is, and how far in.
  static std::pair<std::size_t, double> cell(double a, double lower, double upper,
                                             std::size_t count) {
    const double extent = upper - lower, cells = static_cast<double>(count - 1);
    if (!(extent > 0)) return {0, 0.0};
    const double at = cells * std::clamp((a - lower) / extent, 0.0, 1.0), first = std::floor(at);
    return {static_cast<std::size_t>(first), at - first};
  }
};

Grid read_grid(const std::filesystem::path& path) {
  constexpr std::size_t kLongestLine = 1U << 20U;  // [bytes]
  constexpr std::size_t kMost = 1U << 24U;         // values
  NumberFile file(path, kLongestLine);
  Grid grid;
  while (const auto row = file.next()) {
    if (grid.rows == 0) grid.columns = row->size();
    if (row->size() != grid.columns)
      throw InputError(fmt::format("{}has {} numbers, but the first row has {}", file.place(),
                                   row->size(), grid.columns));
    grid.values.insert(grid.values.end(), row->begin(), row->end());
    if (grid.values.size() > kMost)
      throw InputError(fmt::format("{}: has more than {} values", path.string(), kMost));
    ++grid.rows;
  }
  if (grid.rows == 0) throw InputError(path.string() + ": has no numbers");
  return grid;
}

bool keeps(double value, const FieldRules& rules) {
  if (rules.minimum && value < *rules.minimum) return false;
  if (rules.minimum && rules.minimum_excluded && value == *rules.minimum) return false;
  return !rules.maximum || value <= *rules.maximum;
}

}  // namespace

struct Field::Rule {
  Form form;
  std::string source;
  FieldRules rules;
  std::optional<Expression> expression;  // of a formula
  Grid grid;                             // of a map

  [[nodiscard]] double at(const Vec2& parameter, const ParameterRectangle& within) const {
    const double value = form == Form::map ? grid.at(parameter, within)
                                           : (*expression)(std::array{parameter[0], parameter[1]});
    if (!std::isfinite(value) || !keeps(value, rules)) reject(value, parameter);
    return value;
  }

  [[noreturn]] void reject(double value, const Vec2& parameter) const {
    ParameterField field;
    field.unit = rules.unit;
    field.minimum = rules.minimum;
    field.maximum = rules.maximum;
    field.minimum_excluded = rules.minimum_excluded;
    throw InputError(
        {{rules.pointer,
          fmt::format("{} is {:.6g} at a1 = {:.6g}, a2 = {:.6g}, expected {}", source, value,
                      parameter[0], parameter[1], expectation(field, "a finite number"))}});
  }
};

Field::Field(double value) : constant_(value) {}

Field Field::formula(const std::string& text, FieldRules rules) {
  const Expression expression(text, {"a1", "a2"});
  Field field;
  field.rule_ =
      std::make_shared<const Rule>(Rule{Form::formula, text, std::move(rules), expression, Grid{}});
  return field;
}

Field Field::map(const std::filesystem::path& file, FieldRules rules) {
  Field field;
  field.rule_ = std::make_shared<const Rule>(
      Rule{Form::map, file.string(), std::move(rules), std::nullopt, read_grid(file)});
  return field;
}

Field::Form Field::form() const { return rule_ ? rule_->form : Form::constant; }
std::string Field::source() const { return rule_ ? rule_->source : ""; }

double Field::operator()(const Vec2& parameter, const ParameterRectangle& within) const {
  return rule_ ? rule_->at(parameter, within) : constant_;
}

NodeValues Field::values(const Eigen::MatrixX2d& parameters,
                         const ParameterRectangle& within) const {
  NodeValues values(parameters.rows());
  for (Index a = 0; a < values.size(); ++a) values[a] = (*this)(parameters.row(a), within);
  return values;
}

bool PairWeightsField::is_constant() const {
  return std::ranges::all_of(fields_, &Field::is_constant);
}

PairWeights PairWeightsField::operator()(const Vec2& parameter,
                                         const ParameterRectangle& within) const {
  PairWeights weights;
  for (const Pair ij : kPairs)
    weights.w[static_cast<std::size_t>(slot(ij))] = (*this)(ij)(parameter, within);
  return weights;
}

}  // namespace deform
