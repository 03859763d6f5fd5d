/// One declaration of a plugin's parameters: names, types, units, defaults, ranges. From it come
/// the checks, the typed values and the JSON Schema.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "deform/export.h"
#include "deform/plugin/values.h"

namespace deform {

/// One parameter as declared. A scene's value must have `default_value`'s type. (Its copies are
/// made in the library, as copies of a value of so many types take long to compile.)
struct DEFORM_API ParameterField {
  ParameterField();
  ~ParameterField();
  ParameterField(const ParameterField& other);
  ParameterField(ParameterField&& other) noexcept;
  ParameterField& operator=(const ParameterField& other);
  ParameterField& operator=(ParameterField&& other) noexcept;

  std::string name;
  std::string unit;  ///< "" for none, "1" for a dimensionless number
  std::string doc;
  ParameterValue default_value;
  bool required = false;
  /// When absent, another value takes its place, which the doc names; `default_value` then only
  /// says that it is absent, to the plugin and nobody else.
  bool optional = false;
  std::optional<double> minimum, maximum;  ///< each component's range
  bool minimum_excluded = false;
  bool may_be_infinite = false;      ///< the scene says "infinity"
  std::vector<std::string> choices;  ///< of a string
};

using ParameterFields = std::vector<ParameterField>;

/// Appends a field and returns it.
DEFORM_API ParameterField& add_field(ParameterFields& fields, const char* name, const char* unit,
                                     const char* doc, const ParameterValue& default_value);

/// Refines the field declared last.
class FieldRefinement {
 public:
  explicit FieldRefinement(ParameterField* field) : field_(field) {}
  // Each changes the field and returns *this only for the next in a chain: the last result is
  // dropped.
  // NOLINTBEGIN(modernize-use-nodiscard)
  const FieldRefinement& required() const {
    return with([](auto& f) { f.required = true; });
  }
  const FieldRefinement& optional() const {
    return with([](auto& f) { f.optional = true; });
  }
  const FieldRefinement& at_least(double v) const {
    return with([v](auto& f) { f.minimum = v; });
  }
  const FieldRefinement& above(double v) const {
    return with([v](auto& f) { f.minimum = v, f.minimum_excluded = true; });
  }
  const FieldRefinement& at_most(double v) const {
    return with([v](auto& f) { f.maximum = v; });
  }
  const FieldRefinement& may_be_infinite() const {
    return with([](auto& f) { f.may_be_infinite = true; });
  }
  const FieldRefinement& one_of(std::vector<std::string> names) const {
    return with([&names](auto& f) { f.choices = std::move(names); });
  }

 private:
  template <class Change>
  const FieldRefinement& with(Change change) const {
    if (field_ != nullptr) change(*field_);
    return *this;
  }
  // NOLINTEND(modernize-use-nodiscard)
  ParameterField* field_;  // null while values are being filled in
};

/// Passed to `static void Parameters::declare(Declaration<Parameters>&)`; called once to learn the
/// fields and once an object to fill them in:
///
///   struct Parameters {
///     double delta = 0.5;
///     static void declare(Declaration<Parameters>& d) {
///       d("delta", &Parameters::delta, "1/m", "threshold on |B_ij|").at_least(0);
///     }
///   };
template <class P>
class Declaration {
 public:
  explicit Declaration(ParameterFields& fields) : fields_(&fields) {}
  Declaration(P& object, const ParameterValues& values) : object_(&object), values_(&values) {}

  /// T is an alternative of ParameterValue (Index and int are integers, too); Owner is P, or a base
  /// that several plugins' parameters have in common.
  template <class T, class Owner>
  requires std::is_base_of_v<Owner, P> FieldRefinement operator()(const char* name,
                                                                  T Owner::*member,
                                                                  const char* unit,
                                                                  const char* doc) {
    if (object_ != nullptr) {
      if (values_->has(name)) object_->*member = static_cast<T>(values_->get<Stored<T>>(name));
      return FieldRefinement(nullptr);
    }
    ParameterField& field =
        add_field(*fields_, name, unit, doc, static_cast<Stored<T>>(P{}.*member));
    if constexpr (!std::is_same_v<T, Stored<T>>) {  // what the member's type cannot hold is out of
                                                    // range
      if (std::is_unsigned_v<T>) field.minimum = 0;
      if (sizeof(T) < sizeof(std::int64_t)) {
        field.minimum = static_cast<double>(std::numeric_limits<T>::min());
        field.maximum = static_cast<double>(std::numeric_limits<T>::max());
      }
    }
    return FieldRefinement(&field);
  }

 private:
  template <class T>
  using Stored =
      std::conditional_t<std::is_integral_v<T> && !std::is_same_v<T, bool>, std::int64_t, T>;

  ParameterFields* fields_ = nullptr;
  P* object_ = nullptr;
  const ParameterValues* values_ = nullptr;
};

/// For plugins without parameters.
struct NoParameters {
  static void declare(Declaration<NoParameters>& /*declaration*/) {}
};

}  // namespace deform
