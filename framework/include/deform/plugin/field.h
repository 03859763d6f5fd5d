/// Values that may vary over the surface: a number, a formula of a1 and a2, or a map from a file.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deform/export.h"
#include "deform/geometry/pairs.h"
#include "deform/types.h"

namespace deform {

class SampleSet;
class Surface;

/// Symmetric 2 × 2 weights, one a pair ij (eta, xi of the paper).
struct PairWeights {
  std::array<double, 3> w{};  ///< 11, 12 (= 21), 22
  [[nodiscard]] double operator()(Pair ij) const { return w[static_cast<std::size_t>(slot(ij))]; }
  static constexpr PairWeights all(double value) { return {{value, value, value}}; }
};

/// The rectangle of a surface's parameters [m]; a shape's is from 0 to its size.
struct ParameterRectangle {
  Vec2 lower = Vec2::Zero(), upper = Vec2::Zero();
};
/// That of the surface's nodes; on joined sides a whole period.
[[nodiscard]] DEFORM_API ParameterRectangle parameter_rectangle(const Surface& surface);

/// The rules of the parameter that it is, which are checked wherever it is evaluated.
struct FieldRules {
  std::string pointer;  ///< where the scene says it
  std::string unit;
  std::optional<double> minimum, maximum;
  bool minimum_excluded = false;
};

/// A value over the surface. Copies are cheap. Any thread may evaluate it, but formulas only one at
/// a time: do so when an object is made, not in its steps.
class DEFORM_API Field {
 public:
  enum class Form : std::uint8_t { constant, formula, map };

  Field(double value = 0);  // NOLINT(google-explicit-constructor): a number is a field
  /// Formula of a1 and a2 [m], as Expression has them. Throws ExpressionError.
  static Field formula(const std::string& text, FieldRules rules = {});
  /// Reads a file with a grid of values: each line is a row along a1, lines follow each other along
  /// a2, the first number of the first line lies in the rectangle's lower corner, the last number
  /// of the last line in its upper one; bilinear between them. Throws InputError.
  static Field map(const std::filesystem::path& file, FieldRules rules = {});

  [[nodiscard]] Form form() const;
  [[nodiscard]] bool is_constant() const { return rule_ == nullptr; }
  /// The number of a constant one.
  [[nodiscard]] double constant() const { return constant_; }
  /// The formula's text, the map's file name; "" of a constant one.
  [[nodiscard]] std::string source() const;

  /// The value at (a1, a2). Throws InputError, which names the place, when it is not finite or
  /// breaks the rules.
  [[nodiscard]] double operator()(const Vec2& parameter, const ParameterRectangle& within) const;
  /// (N) the values at N places (N × 2).
  [[nodiscard]] NodeValues values(const Eigen::MatrixX2d& parameters,
                                  const ParameterRectangle& within) const;
  /// (N) the values at the nodes, (m) at a set's samples.
  [[nodiscard]] NodeValues at_nodes(const Surface& surface) const;
  [[nodiscard]] NodeValues at_samples(const Surface& surface, const SampleSet& samples) const;

 private:
  struct Rule;
  double constant_ = 0;
  std::shared_ptr<const Rule> rule_;  // null: constant
};

/// Weights at samples; constant ones are kept once.
class WeightsAtSamples {
 public:
  explicit WeightsAtSamples(std::vector<PairWeights> one_or_all)
      : weights_(std::move(one_or_all)) {}
  [[nodiscard]] const PairWeights& operator[](Index sample) const {
    return weights_[weights_.size() == 1 ? 0 : static_cast<std::size_t>(sample)];
  }

 private:
  std::vector<PairWeights> weights_;
};

/// Weights over the surface, each pair's a field.
class DEFORM_API PairWeightsField {
 public:
  PairWeightsField() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): weights are such a field
  PairWeightsField(const PairWeights& weights)
      : fields_{weights.w[0], weights.w[1], weights.w[2]} {}
  explicit PairWeightsField(std::array<Field, 3> fields) : fields_(std::move(fields)) {}
  static PairWeightsField all(const Field& field) {
    return PairWeightsField({field, field, field});
  }

  [[nodiscard]] const Field& operator()(Pair ij) const {
    return fields_[static_cast<std::size_t>(slot(ij))];
  }
  [[nodiscard]] bool is_constant() const;
  /// Throws InputError as Field does.
  [[nodiscard]] PairWeights operator()(const Vec2& parameter,
                                       const ParameterRectangle& within) const;
  [[nodiscard]] WeightsAtSamples at_samples(const Surface& surface, const SampleSet& samples) const;

 private:
  std::array<Field, 3> fields_;
};

}  // namespace deform
