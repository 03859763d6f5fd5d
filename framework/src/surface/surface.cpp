#include "deform/surface/surface.h"

#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "deform/error.h"

#include "scene/nearest_name.h"

namespace deform {
namespace {

/// Nodes on the rim of a selection count, whatever the rounding of their parameters.
constexpr double kRim = 1e-9;

/// Nodes of a surface that were selected so far, and what was wrong with the selectors.
class Selection {
 public:
  explicit Selection(const Surface& surface)
      : surface_(surface), chosen_(static_cast<std::size_t>(surface.nodes())) {}

  void add(const NodeSelector& selector) {
    switch (selector.form) {
      case NodeSelector::Form::centre:
        return add_centre(selector.centre, selector.radius);
      case NodeSelector::Form::box:
        return add_box(selector.lower, selector.upper);
      case NodeSelector::Form::boundary:
        return add_named("boundary", selector.names, surface_.boundary_names(),
                         [this](const std::string& name) { return surface_.boundary(name); });
      case NodeSelector::Form::corners:
        return add_named("corner", selector.names, surface_.corner_names(),
                         [this](const std::string& name) { return surface_.corner(name); });
      case NodeSelector::Form::node:
        return add_numbers(selector.numbers);
    }
  }

  std::vector<Index> nodes() && {
    std::vector<Index> nodes;
    for (std::size_t node = 0; node < chosen_.size(); ++node) {
      if (chosen_[node]) nodes.push_back(static_cast<Index>(node));
    }
    if (nodes.empty() && problems_.empty()) {
      problems_.push_back({"", "selects no node of the surface, " + extent()});
    }
    if (!problems_.empty()) throw InputError(std::move(problems_));
    return nodes;
  }

 private:
  void choose(Index node) { chosen_[static_cast<std::size_t>(node)] = true; }

  void add_centre(const Vec2& centre, double radius) {
    const double rim = kRim * std::max(radius, centre.lpNorm<Eigen::Infinity>());
    const Vec2 reach = Vec2::Constant(radius + rim);
    add_closed(centre - reach, centre + reach);
  }

  void add_box(const Vec2& lower, const Vec2& upper) {
    const double scale = std::max(lower.lpNorm<Eigen::Infinity>(), upper.lpNorm<Eigen::Infinity>());
    const Vec2 rim = Vec2::Constant(kRim * scale);
    add_closed(lower - rim, upper + rim);
  }

  void add_closed(const Vec2& lower, const Vec2& upper) {
    const Eigen::MatrixX2d& a = surface_.parameters();
    for (Index node = 0; node < a.rows(); ++node) {
      const Vec2 at = a.row(node);
      if ((at.array() >= lower.array()).all() && (at.array() <= upper.array()).all()) choose(node);
    }
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
    problems_.push_back({"", message});
  }

  void add_numbers(const std::vector<std::int64_t>& numbers) {
    for (const std::int64_t number : numbers) {
      if (number >= 0 && number < surface_.nodes()) {
        choose(number);
      } else {
        problems_.push_back({"", "the surface has no node " + std::to_string(number) +
                                     ", its nodes are 0 to " +
                                     std::to_string(surface_.nodes() - 1)});
      }
    }
  }

  [[nodiscard]] std::string extent() const {
    if (surface_.nodes() == 0) return "which has none";
    const auto& a = surface_.parameters();
    const Eigen::RowVector2d lower = a.colwise().minCoeff();
    const Eigen::RowVector2d upper = a.colwise().maxCoeff();
    return fmt::format("whose parameters are [{:.6g}, {:.6g}] to [{:.6g}, {:.6g}]", lower[0],
                       lower[1], upper[0], upper[1]);
  }

  const Surface& surface_;
  std::vector<bool> chosen_;
  std::vector<Problem> problems_;
};

}  // namespace

Surface::~Surface() = default;

std::vector<Index> select_nodes(const Surface& surface, const NodeSelection& where) {
  Selection selection(surface);
  for (const NodeSelector& selector : where.selectors) selection.add(selector);
  return std::move(selection).nodes();
}

}  // namespace deform
