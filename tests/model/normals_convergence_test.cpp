/// Angle errors of the normal estimators on known surfaces at three resolutions: orders and closed
/// forms, and the identity that Gauss' formula gives the cross product's direction.
/// `--gtest_filter=*Table*` prints the whole table.
#include <cmath>
#include <cstdio>
#include <numbers>

#include <fmt/format.h>

#include "deform/check/known_surfaces.h"
#include "deform/surface/surface.h"

#include "model/support/simulate.h"

namespace deform {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// A grid, its samples, and the geometry of a known surface on it.
struct Discretised {
  std::shared_ptr<Surface> surface;
  NodeVectors r;
  Geometry geometry;
  [[nodiscard]] const SampleSet& samples() const { return surface->samples(SampleRole::bending); }
};

template <class Interface>
std::shared_ptr<Interface> make(const std::string& name,
                                const std::shared_ptr<ParameterValues>& values,
                                const Surface* surface) {
  const auto registry = test::built_in();
  Setup setup(
      [registry](const PluginUse& use, const Setup& s) { return registry->create(use, s); });
  static const NodeVectors none;
  static const NodeValues no_areas;
  if (surface != nullptr) setup.with_surface(*surface, none, no_areas);
  return registry->create<Interface>({Interface::kKind, name, values, ""}, setup);
}

Discretised discretise(const KnownSurface& known, std::int64_t n, const std::string& scheme,
                       const std::string& border) {
  auto values = std::make_shared<ParameterValues>();
  values->set("nodes", std::array<std::int64_t, 2>{n, n});
  values->set("differences", scheme);
  values->set("border", border);
  Discretised d;
  d.surface = make<Surface>("grid", values, nullptr);
  const auto& a = d.surface->parameters();
  d.r.resize(a.rows(), 3);
  for (Index i = 0; i < a.rows(); ++i) d.r.row(i) = known.r(a(i, 0), a(i, 1));
  d.geometry = Geometry(d.samples());
  d.geometry.compute(d.samples(), d.r);
  return d;
}

std::shared_ptr<NormalEstimator> estimator(const std::string& name, double delta,
                                           const Surface& surface) {
  auto values = std::make_shared<ParameterValues>();
  if (name == "gauss") values->set("delta", delta);
  return make<NormalEstimator>(name, values, &surface);
}

/// Largest angle over the samples where r_ij is there and |B_ij| > delta, to the true normal or to
/// the set's own exact one. A negative B turns Terzopoulos' r_ij round: the smaller angle to the
/// undirected line counts here, as the table speaks of directions.
enum class Against { truth, exact };
double largest_angle(const Discretised& d, const KnownSurface& known, const std::string& name,
                     Pair ij, Against against, double delta = 1e-3) {
  const auto normal = estimator(name, 0, *d.surface);
  double worst = 0;
  for (Index first = 0; first < d.geometry.size(); first += kBlock) {
    const GeometryBlock block =
        d.geometry.block(first, std::min(kBlock, d.geometry.size() - first));
    AffineNormal estimate;
    normal->estimate(block, ij, estimate);
    for (Index s = 0; s < block.size(); ++s) {
      const Index sample = first + s;
      const bool there = d.samples().computable(second(ij), sample) &&
                         d.samples().computable(Derivative::d1, sample) &&
                         d.samples().computable(Derivative::d2, sample);
      if (!there || std::abs(block.B(ij)[static_cast<std::size_t>(s)]) <= delta) continue;
      const Vec2 a = d.samples().parameters()[static_cast<std::size_t>(sample)];
      const Vec3 to = against == Against::truth ? known.n(a.x(), a.y()) : Vec3(block.n()[s]);
      const double measured = angle(estimate.at(s, block, ij), to);
      worst =
          std::max(worst, name == "terzopoulos" ? std::min(measured, std::numbers::pi - measured)
                                                : measured);
    }
  }
  return worst;
}

TEST(Gauss, IsParallelToTheCrossProductAtTheSameStateAndFrame) {
  for (const KnownSurface& known : known_surfaces())
    for (const char* scheme : {"forward", "central"})
      for (const char* border : {"paper", "one_sided"})
        for (const std::int64_t n : {17, 33, 65}) {
          const Discretised d = discretise(known, n, scheme, border);
          for (const Pair ij : kPairs)
            EXPECT_LT(largest_angle(d, known, "gauss", ij, Against::exact), 1e-8)
                << known.name << " " << scheme << " " << border << " " << n << " pair " << slot(ij);
        }
}

/// Error of the exact estimator's frame: first order forward, second order central.
TEST(Orders, AreOneForwardAndTwoCentral) {
  for (const KnownSurface& known : known_surfaces())
    for (const char* border : {"paper", "one_sided"}) {
      const auto error = [&](const char* scheme, std::int64_t n) {
        return largest_angle(discretise(known, n, scheme, border), known, "exact", Pair::p11,
                             Against::truth, -1);
      };
      const double forward = std::log2(error("forward", 33) / error("forward", 65));
      EXPECT_NEAR(forward, 1.0, 0.1) << known.name << " " << border;
      const double coarse = error("central", 33), fine = error("central", 65);
      // At least: a paraboloid's are exact, a circle's cancel but at the border.
      if (fine > 1e-10) {
        EXPECT_GT(std::log2(coarse / fine), 1.85) << known.name << " " << border;
      }
      if (known.name == "uneven cylinder" || known.name == "saddle") {
        EXPECT_LT(std::log2(coarse / fine), 2.15) << known.name << " " << border;
      }
    }
}

/// 3.04°, 1.52°, 0.76°: an independent prototype's values for this patch.
TEST(Orders, ForwardFrameOnASpherePatch) {
  const KnownSurface sphere = known_surfaces().front();
  const std::array<std::pair<std::int64_t, double>, 3> table{{{17, 3.04}, {33, 1.52}, {65, 0.76}}};
  for (const auto& [n, degrees] : table)
    EXPECT_NEAR(largest_angle(discretise(sphere, n, "forward", "one_sided"), sphere, "exact",
                              Pair::p11, Against::truth) /
                    kDegree,
                degrees, 0.005);
}

constexpr std::array<std::int64_t, 3> kNodes{17, 33, 65};
/// Angle [rad] of the parameter 0 … 1 along a circle of the sphere patch and the cylinder.
constexpr double kArc = 1.2;

/// Errors on grids of kNodes² nodes [rad].
using Errors = std::array<double, 3>;
double order_of(const Errors& e) { return std::log2(e[1] / e[2]); }
/// Terms of the next order change a measured order by about a mesh width, 1/64, over the length in
/// which the surface changes.
constexpr double kOrderTolerance = 0.05;
/// Angles of second differences of positions that are rounded to 1e-16, over curvatures above 1e-3.
constexpr double kRounding = 1e-8;

/// The direction that r_1 and r_2 give, of which that of Gauss' formula is the same: differences
/// are of first order forward, of second order central, and so are the three-point rows at a
/// border. Two kinds of surfaces do better.
void expect_order_of_frame(const KnownSurface& known, const std::string& scheme, const Errors& e) {
  if (scheme == "forward") {
    EXPECT_NEAR(order_of(e), 1, kOrderTolerance);
  } else if (known.name == "paraboloid") {
    EXPECT_LT(e[0], kRounding);  // differences of polynomials of second degree are exact
    EXPECT_LT(e[2], kRounding);
  } else if (known.name == "sphere patch" || known.name == "cylinder") {
    // A chord between equal arcs is parallel to the tangent; three-point rows err by h² r_111 / 3
    // along it, too, and by h³ r_1111 / 4 across it.
    EXPECT_NEAR(order_of(e), 3, kOrderTolerance);
    if (known.name == "cylinder") {
      const double h = kArc / 64;
      EXPECT_NEAR(e[2], h * h * h / 4, h * h * h * h);
    }
  } else {
    EXPECT_NEAR(order_of(e), 2, kOrderTolerance);
  }
}

/// Where r_11 = Γ¹_11 r_1 + B_11 n, the angle between r_11 and n is arctan |φ''| / φ'² on a
/// cylinder with the parameter φ(u). This is the largest.
double uneven_cylinder_limit() {
  double largest = 0;
  constexpr int kSteps = 100000;
  constexpr double kPi = std::numbers::pi;
  for (int i = 0; i <= kSteps; ++i) {
    const double u = static_cast<double>(i) / kSteps;
    const double rate = 1.4 * (1 + 0.3 * kPi * std::cos(2 * kPi * u)),
                 change = 1.4 * 0.6 * kPi * kPi * std::sin(2 * kPi * u);
    largest = std::max(largest, std::atan2(std::abs(change), rate * rate));
  }
  return largest;
}

/// Terzopoulos takes r_ij for the normal. Its error does not vanish with the mesh but where
/// parameter lines are geodesics of even parameter; there, only rows at the border, which are those
/// of the next line, are wrong: by the angle of one step. Differences of these surfaces are exact
/// as directions.
void expect_terzopoulos(const KnownSurface& known, Pair ij, const Errors& e) {
  for (std::size_t g = 0; g < 3; ++g) {
    const double step = kArc / static_cast<double>(kNodes[g] - 1);
    if (known.name == "cylinder" || (known.name == "sphere patch" && ij == Pair::p22)) {
      EXPECT_NEAR(e[g], step, kRounding);
    } else if (known.name == "sphere patch") {
      // Circles of latitude: r_11 points to the axis. The largest angle is at a corner.
      EXPECT_NEAR(e[g], std::acos(std::cos(kArc / 2) * std::cos(step)), kRounding);
    } else if (known.name == "uneven cylinder") {
      EXPECT_LT(e[g], uneven_cylinder_limit() + kRounding);
    } else {  // of a graph z(x, y), r_ij is vertical
      const Vec3 n = known.n(1, 1);
      EXPECT_NEAR(e[g], std::acos(n.z()), kRounding);
    }
  }
  if (known.name == "uneven cylinder") {
    EXPECT_NEAR(order_of(e), 0, kOrderTolerance);
    EXPECT_NEAR(e[2], uneven_cylinder_limit(), kDegree);
  }
}

/// The whole table, for docs/verification.md.
TEST(NormalsTable, HasTheOrdersOfDifferencesAndClosedForms) {
  std::printf("\nlargest angle to the true normal [degree], border one_sided\n");
  std::printf("%-16s %-8s %-12s %-3s %10s %10s %10s %6s\n", "surface", "scheme", "estimator", "ij",
              "17²", "33²", "65²", "order");
  for (const KnownSurface& known : known_surfaces())
    for (const char* scheme : {"forward", "central"}) {
      const std::array<Discretised, 3> grids{discretise(known, kNodes[0], scheme, "one_sided"),
                                             discretise(known, kNodes[1], scheme, "one_sided"),
                                             discretise(known, kNodes[2], scheme, "one_sided")};
      for (const std::string name : {"terzopoulos", "gauss", "exact"})
        for (const Pair ij : kPairs) {
          Errors e{};
          for (std::size_t g = 0; g < 3; ++g)
            e[g] = largest_angle(grids[g], known, name, ij, Against::truth);
          if (e[2] == 0) continue;  // B_ij = 0 everywhere: no direction
          const char* pair_name = ij == Pair::p11 ? "11" : ij == Pair::p12 ? "12" : "22";
          SCOPED_TRACE(fmt::format("{} {} {} {}", known.name, scheme, name, pair_name));
          std::printf("%-16s %-8s %-12s %-3s %10.3e %10.3e %10.3e %6.2f\n", known.name.c_str(),
                      scheme, name.c_str(), pair_name, e[0] / kDegree, e[1] / kDegree,
                      e[2] / kDegree, order_of(e));
          if (name == "terzopoulos")
            expect_terzopoulos(known, ij, e);
          else
            expect_order_of_frame(known, scheme, e);
        }
    }
}

}  // namespace
}  // namespace deform
