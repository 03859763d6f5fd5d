#include "triangles.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include <deform/error.h>

namespace mesh {
namespace {

using deform::NodeVectors;
using deform::Vec3;

/// Twice a triangle's area beside the square of its longest side, from which on it is one.
constexpr double kLeastArea = 1e-10;
/// So many of each kind of problem are named.
constexpr std::size_t kMostNamed = 5;

/// Numbers of what is wrong, for one sentence.
class Found {
 public:
  void add(std::int64_t number) { numbers_.push_back(number); }
  [[nodiscard]] bool any() const { return !numbers_.empty(); }
  [[nodiscard]] std::string list() const {
    std::string text;
    for (std::size_t i = 0; i < std::min(numbers_.size(), kMostNamed); ++i)
      text += (i > 0 ? ", " : "") + std::to_string(numbers_[i]);
    if (numbers_.size() > kMostNamed)
      text += " and " + std::to_string(numbers_.size() - kMostNamed) + " more";
    return text;
  }
  [[nodiscard]] std::string count() const { return std::to_string(numbers_.size()); }

 private:
  std::vector<std::int64_t> numbers_;
};

/// Makes triangles of polygons step by step.
class Maker {
 public:
  Maker(Polygons polygons, const std::string& file, bool repairs, std::vector<std::string>& mended)
      : from_(std::move(polygons)), file_(&file), repairs_(repairs), mended_(&mended) {}

  Triangles make() {
    check_numbers();
    throw_problems();
    join_places();
    cut();
    drop_doubled();
    drop_unused();
    throw_problems();
    orient();
    throw_problems();
    find_borders();
    throw_problems();
    return std::move(out_);
  }

 private:
  using Edge = std::pair<std::int32_t, std::int32_t>;

  void note(const std::string& problem) { problems_.push_back({"/path", *file_ + ": " + problem}); }
  void throw_problems() {
    if (!problems_.empty()) throw deform::InputError(std::move(problems_));
  }
  /// Says what was mended, or notes what would be.
  void mend(const Found& found, const std::string& what, const std::string& done) {
    if (!found.any()) return;
    if (repairs_)
      mended_->push_back(found.count() + " " + done);
    else
      note(what + " " + found.list() + " (\"repair\": true: " + done + ")");
  }

  void check_numbers() {
    const Index vertices = from_.positions.rows();
    Found infinite, unknown, thin;
    for (Index a = 0; a < vertices; ++a)
      if (!from_.positions.row(a).allFinite()) infinite.add(a);
    for (Index f = 0; f < from_.faces.size(); ++f) {
      const auto [begin, end] = corners(f);
      if (end - begin < 3) thin.add(f);
      for (auto k = begin; k < end; ++k)
        if (const auto a = from_.faces.nodes[k]; a < 0 || a >= vertices) {
          unknown.add(f);
          break;
        }
    }
    if (infinite.any()) note("positions that are not finite: of vertices " + infinite.list());
    if (unknown.any())
      note("polygons " + unknown.list() + " name vertices that are not there; there are " +
           std::to_string(vertices));
    if (thin.any()) note("polygons " + thin.list() + " have less than three corners");
    if (from_.faces.size() == 0) note("has no polygons");
  }

  [[nodiscard]] std::pair<std::size_t, std::size_t> corners(Index f) const {
    const auto i = static_cast<std::size_t>(f);
    return {static_cast<std::size_t>(from_.faces.begin[i]),
            static_cast<std::size_t>(from_.faces.begin[i + 1])};
  }

  void join_places() {
    Polygons joined = from_;
    const Index doubled = weld(joined);
    if (doubled == 0) return;
    if (repairs_) {
      from_ = std::move(joined);
      mended_->push_back(std::to_string(doubled) + " vertices at the place of others made one");
      return;
    }
    std::map<std::array<double, 3>, Index> places;
    Found found;
    for (Index a = 0; a < from_.positions.rows(); ++a)
      if (!places
               .emplace(
                   std::array{from_.positions(a, 0), from_.positions(a, 1), from_.positions(a, 2)},
                   a)
               .second)
        found.add(a);
    mend(found, "vertices at the place of an earlier one:", "made one");
  }

  /// Fans of triangles; quadrilaterals by their shorter diagonal.
  void cut() {
    out_.positions = from_.positions;
    out_.group_names = from_.group_names;
    Found twice, flat;
    for (Index f = 0; f < from_.faces.size(); ++f) {
      const auto [begin, end] = corners(f);
      std::vector<std::int32_t> p(from_.faces.nodes.begin() + static_cast<std::ptrdiff_t>(begin),
                                  from_.faces.nodes.begin() + static_cast<std::ptrdiff_t>(end));
      if (std::set<std::int32_t>(p.begin(), p.end()).size() < p.size()) {
        twice.add(f);
        continue;
      }
      begin_at_best(p);
      for (std::size_t k = 2; k < p.size(); ++k) {
        const Triangle t{p[0], p[k - 1], p[k]};
        if (!has_area(t)) {
          flat.add(f);
          continue;
        }
        out_.all.push_back(t);
        out_.group.push_back(from_.group.empty() ? -1 : from_.group[static_cast<std::size_t>(f)]);
        polygon_.push_back(f);
      }
    }
    mend(twice, "polygons that name a vertex twice:", "polygons that name a vertex twice dropped");
    mend(flat, "polygons without area:", "triangles without area dropped");
  }

  /// Turns a polygon so that the fan from its first corner is the best: quadrilaterals by their
  /// shorter diagonal, others by the largest of the fans' least triangles.
  void begin_at_best(std::vector<std::int32_t>& p) const {
    if (p.size() == 3) return;
    Vec3 normal = Vec3::Zero();
    for (std::size_t k = 2; k < p.size(); ++k)
      normal += doubled_area(out_.positions, {p[0], p[k - 1], p[k]});
    const auto worth = [&](std::size_t first) {
      if (p.size() == 4) return -diagonal(p[first], p[(first + 2) % 4]);
      double least = deform::kInfinity;
      for (std::size_t k = 2; k < p.size(); ++k)
        least = std::min(
            least, normal.dot(doubled_area(out_.positions, {p[first], p[(first + k - 1) % p.size()],
                                                            p[(first + k) % p.size()]})));
      return least;
    };
    std::size_t best = 0;
    for (std::size_t first = 1; first < p.size(); ++first)
      if (worth(first) > worth(best)) best = first;
    std::rotate(p.begin(), p.begin() + static_cast<std::ptrdiff_t>(best), p.end());
  }

  [[nodiscard]] double diagonal(std::int32_t a, std::int32_t b) const {
    return (out_.positions.row(a) - out_.positions.row(b)).squaredNorm();
  }
  [[nodiscard]] bool has_area(const Triangle& t) const {
    const double longest =
        std::max({diagonal(t[0], t[1]), diagonal(t[1], t[2]), diagonal(t[2], t[0])});
    return doubled_area(out_.positions, t).norm() > kLeastArea * longest;
  }

  void drop_doubled() {
    std::set<Triangle> known;
    Found doubled;
    keep_if([&](std::size_t t) {
      Triangle sorted = out_.all[t];
      std::ranges::sort(sorted);
      const bool is_new = known.insert(sorted).second;
      if (!is_new) doubled.add(polygon_[t]);
      return is_new;
    });
    mend(doubled,
         "polygons that lie upon others with the same corners:", "polygons upon others dropped");
  }

  template <class Keep>
  void keep_if(const Keep& keep) {
    std::size_t kept = 0;
    for (std::size_t t = 0; t < out_.all.size(); ++t) {
      if (!keep(t)) continue;
      out_.all[kept] = out_.all[t];
      out_.group[kept] = out_.group[t];
      polygon_[kept++] = polygon_[t];
    }
    out_.all.resize(kept);
    out_.group.resize(kept);
    polygon_.resize(kept);
  }

  void drop_unused() {
    std::vector<bool> is_used(static_cast<std::size_t>(out_.nodes()), false);
    for (const Triangle& t : out_.all)
      for (const std::int32_t a : t) is_used[static_cast<std::size_t>(a)] = true;
    Found unused;
    for (Index a = 0; a < out_.nodes(); ++a)
      if (!is_used[static_cast<std::size_t>(a)]) unused.add(a);
    mend(unused, "vertices that no polygon has:", "vertices that no polygon has dropped");
    if (!unused.any() || !repairs_) return;
    std::vector<std::int32_t> number(is_used.size());
    Index kept = 0;
    for (Index a = 0; a < out_.nodes(); ++a) {
      if (!is_used[static_cast<std::size_t>(a)]) continue;
      out_.positions.row(kept) = out_.positions.row(a).eval();
      number[static_cast<std::size_t>(a)] = static_cast<std::int32_t>(kept++);
    }
    out_.positions.conservativeResize(kept, 3);
    for (Triangle& t : out_.all)
      for (std::int32_t& a : t) a = number[static_cast<std::size_t>(a)];
  }

  [[nodiscard]] static Edge edge(const Triangle& t, std::size_t k) {
    const std::int32_t a = t[k], b = t[(k + 1) % 3];
    return {std::min(a, b), std::max(a, b)};
  }
  [[nodiscard]] static bool runs_up(const Triangle& t, std::size_t k) {
    return t[k] < t[(k + 1) % 3];
  }
  struct Side {
    std::size_t triangle, k;
  };

  /// Goes from each triangle to its neighbours, and turns round those that run along the common
  /// edge the same way.
  void orient() {
    std::map<Edge, std::vector<Side>> sides;
    for (std::size_t t = 0; t < out_.all.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) sides[edge(out_.all[t], k)].push_back({t, k});
    Found crowded;
    for (const auto& [e, of] : sides)
      if (of.size() > 2) crowded.add(polygon_[of[2].triangle]);
    if (crowded.any())
      return note("edges that more than two polygons share, at polygons " + crowded.list() +
                  ": no surface");
    enum class Turn : std::int8_t { unknown, as_it_is, round };
    std::vector<Turn> turn(out_.all.size(), Turn::unknown);
    Found turned;
    std::vector<std::size_t> next;
    for (std::size_t first = 0; first < out_.all.size(); ++first) {
      if (turn[first] != Turn::unknown) continue;
      turn[first] = Turn::as_it_is;
      next.assign(1, first);
      while (!next.empty()) {
        const std::size_t t = next.back();
        next.pop_back();
        for (std::size_t k = 0; k < 3; ++k)
          for (const Side& other : sides[edge(out_.all[t], k)]) {
            if (other.triangle == t) continue;
            const bool same = runs_up(out_.all[t], k) == runs_up(out_.all[other.triangle], other.k);
            const Turn wanted = same == (turn[t] == Turn::as_it_is) ? Turn::round : Turn::as_it_is;
            Turn& found = turn[other.triangle];
            if (found == Turn::unknown) {
              found = wanted;
              next.push_back(other.triangle);
            } else if (found != wanted) {
              return note("polygons " + std::to_string(polygon_[t]) + " and " +
                          std::to_string(polygon_[other.triangle]) +
                          " cannot run the same way round: the surface has one side only, as a "
                          "Möbius strip");
            }
          }
      }
    }
    for (std::size_t t = 0; t < turn.size(); ++t)
      if (turn[t] == Turn::round) {
        turned.add(polygon_[t]);
        std::swap(out_.all[t][1], out_.all[t][2]);
      }
    mend(turned, "polygons that run the other way round than their neighbours:",
         "polygons turned to run as their neighbours do");
  }

  void find_borders() {
    std::map<Edge, std::size_t> left;  // the triangle to the left of an edge, in its direction
    for (std::size_t t = 0; t < out_.all.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        left.emplace(Edge{out_.all[t][k], out_.all[t][(k + 1) % 3]}, t);
    std::map<std::int32_t, std::int32_t> next;  // along borders, the surface to the left
    for (const auto& [e, t] : left)
      if (!left.contains({e.second, e.first})) next.emplace(e.first, e.second);
    check_fans(left, next);
    if (!problems_.empty()) return;
    std::vector<std::pair<double, Loop>> loops;
    while (!next.empty()) {
      Loop loop;
      double length = 0;
      std::int32_t at = next.begin()->first;
      for (auto edge = next.find(at); edge != next.end(); edge = next.find(at)) {
        loop.push_back(at);
        length += std::sqrt(diagonal(at, edge->second));
        at = edge->second;
        next.erase(edge);
      }
      loops.emplace_back(length, std::move(loop));
    }
    std::ranges::stable_sort(loops, std::greater<>(), &std::pair<double, Loop>::first);
    for (auto& [length, loop] : loops) out_.borders.push_back(std::move(loop));
  }

  /// Around each node its triangles follow one another, from the border if it is at one.
  void check_fans(const std::map<Edge, std::size_t>& left,
                  const std::map<std::int32_t, std::int32_t>& next) {
    std::vector<std::size_t> around(static_cast<std::size_t>(out_.nodes()), 0);
    std::vector<std::int32_t> second(around.size(), -1);
    for (const Triangle& t : out_.all)
      for (std::size_t k = 0; k < 3; ++k) {
        ++around[static_cast<std::size_t>(t[k])];
        second[static_cast<std::size_t>(t[k])] = t[(k + 1) % 3];
      }
    Found knots;
    for (std::int32_t a = 0; a < static_cast<std::int32_t>(out_.nodes()); ++a) {
      const auto border = next.find(a);
      const std::int32_t first =
          border != next.end() ? border->second : second[static_cast<std::size_t>(a)];
      std::size_t fan = 0;
      std::int32_t to = first;
      do {
        const auto edge = left.find({a, to});
        if (edge == left.end()) break;
        const Triangle& t = out_.all[edge->second];
        to = t[0] == a ? t[2] : t[1] == a ? t[0] : t[1];
        ++fan;
      } while (to != first);
      if (fan != around[static_cast<std::size_t>(a)]) knots.add(a);
    }
    if (knots.any())
      note("vertices " + knots.list() + " join parts of the surface in a point: no surface");
  }

  Polygons from_;
  const std::string* file_;
  bool repairs_;
  std::vector<std::string>* mended_;
  std::vector<deform::Problem> problems_;
  Triangles out_;
  std::vector<Index> polygon_;  // that each triangle is of
};

}  // namespace

Vec3 doubled_area(const NodeVectors& r, const Triangle& t) {
  const Vec3 a = r.row(t[0]), b = r.row(t[1]), c = r.row(t[2]);
  return (b - a).cross(c - a);
}

Triangles make_triangles(Polygons polygons, const std::string& file, bool repairs,
                         std::vector<std::string>& mended) {
  return Maker(std::move(polygons), file, repairs, mended).make();
}

}  // namespace mesh
