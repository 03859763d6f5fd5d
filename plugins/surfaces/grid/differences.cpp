#include "differences.h"

#include <algorithm>

namespace grid {
namespace {

/// Builds rows of offsets around a node; what leaves an open line does not exist.
class RowMaker {
 public:
  RowMaker(Index n, bool periodic) : n_(n), periodic_(periodic) {}

  [[nodiscard]] Row row(Index i, const std::vector<std::pair<Index, double>>& offsets) const {
    Row result;
    for (const auto& [offset, coefficient] : offsets) {
      Index at = i + offset;
      if (periodic_) at = (at % n_ + n_) % n_;
      if (at < 0 || at >= n_) return {};
      result.emplace_back(at, coefficient);
    }
    std::ranges::sort(result);
    return result;
  }

 private:
  Index n_;
  bool periodic_;
};

}  // namespace

Line make_line(Index n, double h, bool periodic, Scheme scheme, Border border) {
  const RowMaker make(n, periodic);
  const double f = 1 / h, c = 1 / (2 * h), s = 1 / (h * h);
  const std::vector<std::pair<Index, double>> forward{{0, -f}, {1, f}}, backward{{-1, -f}, {0, f}},
      central{{-1, -c}, {1, c}}, second{{-1, s}, {0, -2 * s}, {1, s}};

  Line line;
  for (Index i = 0; i < n; ++i) {
    line.d.push_back(make.row(i, scheme == Scheme::forward ? forward : central));
    line.minus.push_back(make.row(i, scheme == Scheme::forward ? backward : central));
    line.dd.push_back(make.row(i, second));
    Row frame = make.row(i, central);
    if (frame.empty()) frame = make.row(i, i == 0 ? forward : backward);
    line.frame.push_back(frame);
  }
  if (periodic || border == Border::paper) return line;

  // Nearest line where the difference exists; the central first difference keeps its second order
  // by three points instead.
  const auto last = static_cast<std::size_t>(n - 1);
  line.dd.front() = line.dd[1];
  line.dd.back() = line.dd[last - 1];
  if (scheme == Scheme::forward) {
    line.d.back() = line.d[last - 1];
    line.minus.front() = line.minus[1];
  } else {
    line.d.front() = make.row(0, {{0, -3 * c}, {1, 4 * c}, {2, -c}});
    line.d.back() = make.row(n - 1, {{-2, c}, {-1, -4 * c}, {0, 3 * c}});
    line.minus = line.d;
  }
  return line;
}

}  // namespace grid
