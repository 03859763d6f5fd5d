#include "deform/surface/surface.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include <fmt/format.h>

#include "deform/error.h"

#include "surface/patches.h"
#include "text/nearest_name.h"

namespace deform {
namespace {

/// Numbers of nodes that a message lists.
constexpr std::size_t kMostListed = 5;

/// Nodes of a surface that were selected so far, and what was wrong with the selectors.
class Selection {
 public:
  Selection(const Surface& surface, const std::string& pointer)
      : surface_(surface), pointer_(pointer), chosen_(static_cast<std::size_t>(surface.nodes())) {}

  void add(const NodeSelector& selector) {
    switch (selector.form) {
      case NodeSelector::Form::centre:
      case NodeSelector::Form::box:
        return add_within(*rectangle_of(selector));
      case NodeSelector::Form::boundary:
        return add_named("boundary", selector.names, surface_.boundary_names(),
                         [this](const std::string& name) { return surface_.boundary(name); });
      case NodeSelector::Form::corners:
        return add_named("corner", selector.names, surface_.corner_names(),
                         [this](const std::string& name) { return surface_.corner(name); });
      case NodeSelector::Form::node:
        return add_numbers(selector.numbers);
      case NodeSelector::Form::sphere:
        return add_where(
            [&](const Vec3& r) { return (r - selector.place).norm() <= selector.radius; });
      case NodeSelector::Form::space:
        return add_where([&](const Vec3& r) {
          return (r.array() >= selector.place.array()).all() &&
                 (r.array() <= selector.opposite.array()).all();
        });
      case NodeSelector::Form::nearest: {
        Index nearest = 0;
        (surface_.rest().rowwise() - selector.place.transpose())
            .rowwise()
            .squaredNorm()
            .minCoeff(&nearest);
        return choose(nearest);
      }
    }
  }

  std::vector<Index> nodes() && {
    std::vector<Index> nodes;
    for (std::size_t node = 0; node < chosen_.size(); ++node) {
      if (chosen_[node]) nodes.push_back(static_cast<Index>(node));
    }
    if (nodes.empty() && problems_.empty()) {
      problems_.push_back({pointer_, "selects no node of the surface, " + extent()});
    }
    if (!problems_.empty()) throw InputError(std::move(problems_));
    return nodes;
  }

 private:
  void choose(Index node) { chosen_[static_cast<std::size_t>(node)] = true; }

  template <class Predicate>
  void add_where(const Predicate& is_in) {
    for (Index node = 0; node < surface_.nodes(); ++node)
      if (is_in(Vec3(surface_.rest().row(node)))) choose(node);
  }

  void add_within(const ParameterRectangle& rectangle) {
    if (!surface_.has_chart()) {
      problems_.push_back({pointer_,
                           "selects by parameters, which this surface does not have; expected "
                           "\"space\", \"sphere\", \"nearest\", \"boundary\" or \"node\""});
      return;
    }
    const Eigen::MatrixX2d& a = surface_.parameters();
    const Vec2 period = surface_.period();
    for (Index node = 0; node < a.rows(); ++node)
      if (contains(rectangle, a.row(node), period)) choose(node);
  }

  void add_named(const std::string& what, const std::vector<std::string>& wanted,
                 const std::vector<std::string>& known,
                 const std::function<std::vector<Index>(const std::string&)>& nodes_of) {
    for (const std::string& name : wanted) {
      const bool all = name == "all";
      if (!all && std::find(known.begin(), known.end(), name) == known.end()) {
        note_unknown(what, name, known);
        continue;
      }
      for (const std::string& part : all ? known : std::vector{name}) {
        for (const Index node : nodes_of(part)) choose(node);
      }
    }
  }

  void note_unknown(const std::string& what, const std::string& name,
                    std::vector<std::string> known) {
    std::string message = "the surface has no " + what + " \"" + name + "\"";
    if (known.empty()) {
      message += ", nor any other";
    } else {
      known.emplace_back("all");
      message += did_you_mean(name, known);
    }
    problems_.push_back({pointer_, message});
  }

  void add_numbers(const std::vector<std::int64_t>& numbers) {
    std::vector<std::int64_t> unknown;
    for (const std::int64_t number : numbers) {
      if (number >= 0 && number < surface_.nodes()) {
        choose(number);
      } else {
        unknown.push_back(number);
      }
    }
    if (unknown.empty()) return;
    // A list for another surface may have a million of them: one problem for all.
    const std::size_t listed = std::min(unknown.size(), kMostListed);
    std::string message = fmt::format("the surface has no node {}",
                                      fmt::join(std::span(unknown).first(listed), ", "));
    if (listed < unknown.size()) message += fmt::format(" and {} more", unknown.size() - listed);
    problems_.push_back(
        {pointer_, message + fmt::format("; its nodes are 0 to {}", surface_.nodes() - 1)});
  }

  [[nodiscard]] std::string extent() const {
    if (surface_.nodes() == 0) return "which has none";
    const auto& a = surface_.parameters();
    const Eigen::RowVector2d lower = a.colwise().minCoeff();
    const Eigen::RowVector2d upper = a.colwise().maxCoeff();
    const Eigen::RowVector3d low = surface_.rest().colwise().minCoeff();
    const Eigen::RowVector3d high = surface_.rest().colwise().maxCoeff();
    const std::string place =
        fmt::format("[{:.6g}, {:.6g}, {:.6g}] to [{:.6g}, {:.6g}, {:.6g}] at rest", low[0], low[1],
                    low[2], high[0], high[1], high[2]);
    if (!surface_.has_chart()) return "which is within " + place;
    return fmt::format("whose parameters are [{:.6g}, {:.6g}] to [{:.6g}, {:.6g}]; it is within {}",
                       lower[0], lower[1], upper[0], upper[1], place);
  }

  const Surface& surface_;
  const std::string& pointer_;  // of the selection, in the scene
  std::vector<bool> chosen_;
  std::vector<Problem> problems_;
};

}  // namespace

Surface::~Surface() = default;
std::vector<ScalarUnknown> Surface::scalars() const { return {}; }

void require_chart(const Surface& surface, const std::string& what) {
  if (!surface.has_chart())
    throw InputError(what +
                     " needs parameters a1 and a2, which this surface does not have: each of its "
                     "samples has directions of its own");
}

std::vector<Index> select_nodes(const Surface& surface, const NodeSelection& where) {
  Selection selection(surface, where.pointer);
  for (const NodeSelector& selector : where.selectors) selection.add(selector);
  return std::move(selection).nodes();
}

}  // namespace deform
