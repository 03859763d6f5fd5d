#include <array>
#include <cmath>
#include <sstream>

#include <deform/plugin/expression.h>
#include <deform/surface/shape.h>

namespace {
using namespace deform;

struct Parameters {
  std::string x = "a1", y = "a2", z = "0";
  NamedNumbers constants;
  static void declare(Declaration<Parameters>& d) {
    d("x", &Parameters::x, "m",
      "formula of a1 and a2 [m], of the surface's size L1 and L2 [m], of pi and the constants");
    d("y", &Parameters::y, "m", "the same");
    d("z", &Parameters::z, "m", "the same");
    d("constants", &Parameters::constants, "", "numbers that the formulas call by these names");
  }
};

class Formula final : public Shape {
 public:
  Formula(const Parameters& p, const Setup& /*setup*/)
      : components_{component("/x", p.x, p), component("/y", p.y, p), component("/z", p.z, p)} {}

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& size) const override {
    NodeVectors r(parameters.rows(), 3);
    for (const Index c : {0, 1, 2}) {
      const Expression& f = components_[static_cast<std::size_t>(c)];
      for (Index a = 0; a < r.rows(); ++a) {
        r(a, c) = f(std::array{parameters(a, 0), parameters(a, 1), size[0], size[1]});
        if (!std::isfinite(r(a, c))) reject(c, r(a, c), parameters.row(a));
      }
    }
    return r;
  }

 private:
  /// Also says what is wrong with the constants, where it is these.
  static Expression component(const char* pointer, const std::string& text, const Parameters& p) {
    try {
      return {text, {"a1", "a2", "L1", "L2"}, p.constants};
    } catch (const ExpressionError& error) {
      const bool by_constants = error.what() == error.why();  // no formula is quoted
      throw InputError({Problem{by_constants ? "/constants" : pointer, error.what()}});
    }
  }

  [[noreturn]] void reject(Index component, double value, const Vec2& a) const {
    std::ostringstream why;
    why << "xyz"[component] << " = " << components_[static_cast<std::size_t>(component)].text()
        << " is " << value << " at a1 = " << a[0] << ", a2 = " << a[1]
        << ": a position must be finite";
    throw InputError(why.str());
  }

  std::array<Expression, 3> components_;
};

}  // namespace

DEFORM_PLUGIN(Formula, Parameters, .name = "formula", .version = "1.0",
              .summary = "positions by formulas of a1 and a2",
              .formula = "r = (x(a1, a2), y(a1, a2), z(a1, a2))", .source = "")
