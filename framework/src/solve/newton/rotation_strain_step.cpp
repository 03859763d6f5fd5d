#include "solve/newton/rotation_strain_step.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "deform/error.h"

#include "not_finite.h"

namespace deform {
namespace {

/// Keeps the matrix of a free surface regular: translations, which no link knows. Parts of the mean
/// diagonal; an iterative solver may work in single precision, whose rounding must not outweigh it.
constexpr double kRegular = 1e-9, kRegularInSinglePrecision = 2e-6;
/// A fit whose residual is this part of what it is made of has nothing to correct but rounding.
constexpr double kNegligible = 1e-12;
/// Nodes up to which the matrix, which never changes, is factorised: two triangular solutions are
/// then cheaper than conjugate gradients.
constexpr Index kMostFactorised = 20000;
/// Part of the fit's error that an iterative solver may leave: what it corrects is of second order.
constexpr double kTolerance = 1e-2;

/// Two corners of a face each, once; those that lie upon each other at rest have no direction.
std::vector<RotationStrainStep::Link> links_of(const Faces& faces, const NodeVectors& rest) {
  std::vector<std::pair<Index, Index>> pairs;
  for (std::size_t f = 0; f + 1 < faces.begin.size(); ++f)
    for (auto i = faces.begin[f]; i < faces.begin[f + 1]; ++i)
      for (auto j = faces.begin[f]; j < i; ++j) {
        const Index a = faces.nodes[static_cast<std::size_t>(i)],
                    b = faces.nodes[static_cast<std::size_t>(j)];
        pairs.emplace_back(std::min(a, b), std::max(a, b));
      }
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<RotationStrainStep::Link> links;
  for (const auto& [a, b] : pairs) {
    const double square = (rest.row(b) - rest.row(a)).squaredNorm();
    if (square > 0) links.push_back({a, b, 1 / square});
  }
  return links;
}

Vec3 rotated(const Vec3& by, const Vec3& x) {
  const double angle = by.norm();
  return angle > 0 ? Vec3(Eigen::AngleAxisd(angle, by / angle) * x) : x;
}

BlockMatrix pattern_of(const std::vector<RotationStrainStep::Link>& links, Index nodes) {
  BlockMatrix k;
  k.nodes = nodes;
  auto link = links.begin();
  for (Index a = 0; a < nodes; ++a) {
    k.column.push_back(static_cast<std::int32_t>(a));
    for (; link != links.end() && link->a == a; ++link)
      k.column.push_back(static_cast<std::int32_t>(link->b));
    k.row_begin.push_back(static_cast<std::int32_t>(k.column.size()));
  }
  k.value.assign(9 * k.column.size(), 0.0);
  return k;
}

/// Nodes that links join, directly or by others: each such set, ascending.
std::vector<std::vector<Index>> joined(const std::vector<RotationStrainStep::Link>& links,
                                       Index nodes) {
  std::vector<Index> root(static_cast<std::size_t>(nodes));
  std::iota(root.begin(), root.end(), Index{0});
  const auto root_of = [&root](Index a) {
    for (Index* up = &root[static_cast<std::size_t>(a)]; *up != a;
         up = &root[static_cast<std::size_t>(a)])
      a = *up = root[static_cast<std::size_t>(*up)];
    return a;
  };
  for (const RotationStrainStep::Link& link : links) {
    const Index a = root_of(link.a), b = root_of(link.b);
    root[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  std::vector<std::vector<Index>> sets(static_cast<std::size_t>(nodes));
  for (Index a = 0; a < nodes; ++a) sets[static_cast<std::size_t>(root_of(a))].push_back(a);
  std::erase_if(sets, [](const auto& set) { return set.empty(); });
  return sets;
}

}  // namespace

RotationStrainStep::RotationStrainStep(const Surface& surface, const NodeVectors& rest,
                                       const ReductionMap& map, const std::vector<Freedom>& held,
                                       const SolverSource& solvers)
    : links_(links_of(surface.faces(), rest)),
      laplacian_(pattern_of(links_, map.reduction().nodes())),
      solver_(
          map, laplacian_, held, solvers, [this]() -> const BlockMatrix& { return laplacian_; },
          TangentSolver::Entries::nonzero) {
  for (const auto& [a, b, weight] : links_) {
    const Eigen::Matrix3d block = weight * Eigen::Matrix3d::Identity();
    laplacian_.block(a, a) += block;
    laplacian_.block(b, b) += block;
    laplacian_.block(a, b) -= block;
    mean_ += 2 * weight / static_cast<double>(surface.nodes());
  }
  if (solver_.takes_rows()) find_floating(rest);
}

void RotationStrainStep::find_floating(const NodeVectors& rest) {
  const std::vector<std::uint8_t> held = solver_.unknowns().held();
  for (const std::vector<Index>& nodes : joined(links_, rest.rows()))
    for (int c = 0; c < 3; ++c)
      if (std::ranges::none_of(
              nodes, [&](Index a) { return (held[static_cast<std::size_t>(a)] & (1U << c)) != 0; }))
        floating_.push_back({c, nodes});
}

/// ω_a minimises Σ w |d_b − d_a − ω_a × e|² over the links of a.
double RotationStrainStep::begin(const NodeVectors& r, const NodeVectors& d) {
  from_ = r;
  direction_ = d;
  rotation_.setZero(r.rows(), 3);
  normal_.assign(static_cast<std::size_t>(r.rows()), Eigen::Matrix3d::Zero());
  for (const auto& [a, b, weight] : links_) {
    const Vec3 e = r.row(b) - r.row(a), change = d.row(b) - d.row(a);
    const Eigen::Matrix3d part =
        weight * (e.squaredNorm() * Eigen::Matrix3d::Identity() - e * e.transpose());
    const Vec3 moment = weight * e.cross(change);
    for (const Index node : {a, b}) {
      normal_[static_cast<std::size_t>(node)] += part;
      rotation_.row(node) += moment;
    }
  }
  double largest = 0;
  for (Index a = 0; a < r.rows(); ++a) {
    Eigen::Matrix3d& m = normal_[static_cast<std::size_t>(a)];
    m.diagonal().array() += 1e-9 * m.trace();
    rotation_.row(a) = m.ldlt().solve(Vec3(rotation_.row(a)));
    largest = std::max(largest, rotation_.row(a).norm());
  }
  return largest;
}

bool RotationStrainStep::factorise() {
  if (laplacian_.nodes > kMostFactorised) return false;
  try {
    return solver_.factor(NodeValues::Constant(laplacian_.nodes, kRegular * mean_)).empty();
  } catch (const InputError&) {  // the scene names a solver that does not factorise
    return false;
  }
}

bool RotationStrainStep::prepare() {
  if (is_factorised_ = factorise(); is_factorised_) return true;
  if (solver_.takes_rows()) solver_.put(laplacian_);
  const double regular = floating_.empty() ? kRegular : kRegularInSinglePrecision;
  const NodeValues d = NodeValues::Constant(laplacian_.nodes, regular * mean_);
  return solver_.factor_to_tolerance(d, d, {}, true).empty();
}

std::string RotationStrainStep::solve() {
  return is_factorised_ ? solver_.solve(pull_, correction_)
                        : solver_.solve_to_tolerance(kTolerance, false, pull_, correction_);
}

void RotationStrainStep::take_means_away(NodeVectors& field) const {
  for (const auto& [c, nodes] : floating_) {
    double sum = 0;
    for (const Index a : nodes) sum += field(a, c);
    const double mean = sum / static_cast<double>(nodes.size());
    for (const Index a : nodes) field(a, c) -= mean;
  }
}

/// Solves for the correction of positions; false where no solver can.
bool RotationStrainStep::fit() {
  try {
    take_means_away(pull_);
    if (!is_prepared_) is_prepared_ = prepare();
    if (!is_prepared_ || !solve().empty()) return false;
    take_means_away(correction_);
    return correction_.allFinite();
  } catch (const InputError&) {  // the scene names a solver that does not take this matrix
    return false;
  } catch (const NotFinite&) {
    return false;
  }
}

void RotationStrainStep::at(double s, NodeVectors& r) {
  r = from_ + s * direction_;
  pull_.setZero(r.rows(), 3);
  double at_work = 0;
  for (const auto& [a, b, weight] : links_) {
    const Vec3 e = from_.row(b) - from_.row(a), change = direction_.row(b) - direction_.row(a);
    const Vec3 rotation = 0.5 * (rotation_.row(a) + rotation_.row(b));
    const Vec3 target = rotated(s * rotation, e + s * (change - rotation.cross(e)));
    const Vec3 left = weight * (target - Vec3(r.row(b) - r.row(a)));
    pull_.row(a) -= left;
    pull_.row(b) += left;
    at_work += weight * weight * target.squaredNorm();
  }
  if (pull_.norm() <= kNegligible * std::sqrt(at_work)) return;
  if (fit()) r += correction_;
}

}  // namespace deform
