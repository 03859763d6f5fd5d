#include "deform/model/reduction.h"

#include <algorithm>
#include <string>

#include "deform/error.h"

namespace deform {

Reduction::Reduction(Index nodes) : nodes_(nodes) {
  for (auto& component : kind_) component.assign(static_cast<std::size_t>(nodes), Kind::free);
}

void Reduction::require(Index node, int component, const char* verb) const {
  const std::string what = std::string("it ") + verb;
  if (node < 0 || node >= nodes_)
    throw Error(ExitCode::plugin_failed, what + " node " + std::to_string(node) +
                                             ", expected 0 to " + std::to_string(nodes_ - 1));
  if (component < 0 || component > 2)
    throw Error(ExitCode::plugin_failed, what + " component " + std::to_string(component) +
                                             ", expected 0, 1 or 2 for x, y or z");
}

void Reduction::prescribe(Index node, int component) {
  require(node, component, "prescribes");
  kind_[static_cast<std::size_t>(component)][static_cast<std::size_t>(node)] = Kind::prescribed;
}

void Reduction::tie(const Tie& tie) {
  require(tie.freedom.node, tie.freedom.component, "ties");
  for (const Tie::Part& part : tie.parts)
    require(part.of.node, part.of.component, "ties something to");
  Kind& kind = kind_[static_cast<std::size_t>(tie.freedom.component)]
                    [static_cast<std::size_t>(tie.freedom.node)];
  if (kind != Kind::free) return;
  kind = Kind::tied;
  ties_.push_back(tie);
}

void Reduction::reflect() {
  for (Tie& tie : ties_) {
    if (tie.freedom.component == 2) tie.offset = -tie.offset;
    for (Tie::Part& part : tie.parts)
      if ((part.of.component == 2) != (tie.freedom.component == 2))
        part.coefficient = -part.coefficient;
  }
}

std::vector<Index> Reduction::free_nodes(int component) const {
  std::vector<Index> nodes;
  for (Index node = 0; node < nodes_; ++node) {
    if (free(node, component)) nodes.push_back(node);
  }
  return nodes;
}

namespace {

/// "7, 12, 7": the nodes of ties that wait for each other, from one of them round to it again.
std::string circle_of(const std::vector<Tie>& waiting) {
  const auto next = [&](const Freedom& freedom) {
    const Tie& tie = *std::ranges::find(waiting, freedom, &Tie::freedom);
    return std::ranges::find_if(tie.parts,
                                [&](const Tie::Part& part) {
                                  return std::ranges::find(waiting, part.of, &Tie::freedom) !=
                                         waiting.end();
                                })
        ->of;
  };
  std::vector<Freedom> path{waiting.front().freedom};
  while (std::ranges::count(path, path.back()) == 1) path.push_back(next(path.back()));
  std::string text;
  for (auto at = std::ranges::find(path, path.back()); at != path.end(); ++at)
    text += (text.empty() ? "" : ", ") + std::to_string(at->node);
  return text;
}

}  // namespace

std::vector<Tie> Reduction::ties() const {
  std::vector<Tie> waiting, ordered;
  for (const Tie& tie : ties_)
    if (kind(tie.freedom.node, tie.freedom.component) == Kind::tied) waiting.push_back(tie);
  std::array<std::vector<bool>, 3> known;
  for (int c = 0; c < 3; ++c)
    for (Index node = 0; node < nodes_; ++node)
      known[static_cast<std::size_t>(c)].push_back(kind(node, c) != Kind::tied);
  const auto knows = [&](const Freedom& f) {
    return known[static_cast<std::size_t>(f.component)][static_cast<std::size_t>(f.node)];
  };
  while (!waiting.empty()) {
    std::vector<Tie> later;
    for (Tie& tie : waiting) {
      if (!std::ranges::all_of(tie.parts, [&](const Tie::Part& p) { return knows(p.of); })) {
        later.push_back(std::move(tie));
        continue;
      }
      known[static_cast<std::size_t>(tie.freedom.component)]
           [static_cast<std::size_t>(tie.freedom.node)] = true;
      ordered.push_back(std::move(tie));
    }
    if (later.size() == waiting.size())
      throw InputError("the constraints tie nodes to themselves, in a circle: " + circle_of(later) +
                       "; what a side's derivatives must be for this is said of EdgeNode in "
                       "deform/surface/surface.h");
    waiting = std::move(later);
  }
  return ordered;
}

bool Reduction::ties_mix_components() const {
  return std::ranges::any_of(ties_, [this](const Tie& tie) {
    return kind(tie.freedom.node, tie.freedom.component) == Kind::tied &&
           std::ranges::any_of(tie.parts, [&](const Tie::Part& part) {
             return part.of.component != tie.freedom.component;
           });
  });
}

ReductionMap::ReductionMap(const Reduction& reduction)
    : reduction_(reduction), ties_(reduction.ties()) {
  for (auto& numbers : number_) numbers.assign(static_cast<std::size_t>(reduction_.nodes()), -1);
  for (const Tie& tie : ties_) {
    Row combined;
    for (const Tie::Part& part : tie.parts)
      for (const Tie::Part& inner : row(part.of)) {
        const auto same = std::ranges::find(combined, inner.of, &Tie::Part::of);
        if (same == combined.end()) {
          combined.push_back({inner.of, part.coefficient * inner.coefficient});
        } else {
          same->coefficient += part.coefficient * inner.coefficient;
        }
      }
    number_[static_cast<std::size_t>(tie.freedom.component)]
           [static_cast<std::size_t>(tie.freedom.node)] = static_cast<std::int32_t>(rows_.size());
    rows_.push_back(std::move(combined));
  }
}

ReductionMap::Row ReductionMap::row(const Freedom& freedom) const {
  if (reduction_.free(freedom.node, freedom.component)) return {{freedom, 1.0}};
  const std::int32_t number =
      number_[static_cast<std::size_t>(freedom.component)][static_cast<std::size_t>(freedom.node)];
  return number < 0 ? Row{} : rows_[static_cast<std::size_t>(number)];
}

void ReductionMap::complete(NodeVectors& r, bool with_offsets) const {
  for (const Tie& tie : ties_) {
    double sum = with_offsets ? tie.offset : 0;
    for (const Tie::Part& part : tie.parts)
      sum += part.coefficient * r(part.of.node, part.of.component);
    r(tie.freedom.node, tie.freedom.component) = sum;
  }
}

void ReductionMap::transpose(NodeVectors& f) const {
  for (auto tie = ties_.rbegin(); tie != ties_.rend(); ++tie) {
    double& value = f(tie->freedom.node, tie->freedom.component);
    for (const Tie::Part& part : tie->parts)
      f(part.of.node, part.of.component) += part.coefficient * value;
    value = 0;
  }
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < f.rows(); ++a)
      if (reduction_.prescribed(a, c)) f(a, c) = 0;
}

}  // namespace deform
