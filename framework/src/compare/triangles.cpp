#include "compare/triangles.h"

namespace deform {

std::vector<Triangle> triangles_of(const Faces& faces) {
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f + 1 < faces.begin.size(); ++f) {
    const auto begin = static_cast<std::size_t>(faces.begin[f]);
    const auto end = static_cast<std::size_t>(faces.begin[f + 1]);
    for (std::size_t k = begin + 1; k + 1 < end; ++k)
      triangles.push_back({faces.nodes[begin], faces.nodes[k], faces.nodes[k + 1]});
  }
  return triangles;
}

}  // namespace deform
