/// Fields at the nodes and samples of a surface.
#include <utility>
#include <vector>

#include "deform/plugin/field.h"
#include "deform/surface/surface.h"

namespace deform {

ParameterRectangle parameter_rectangle(const Surface& surface) {
  ParameterRectangle rectangle;
  const Eigen::MatrixX2d& a = surface.parameters();
  if (a.rows() == 0) return rectangle;
  rectangle.lower = a.colwise().minCoeff();
  rectangle.upper = a.colwise().maxCoeff();
  const Vec2 period = surface.period();
  for (const int k : {0, 1})
    if (period[k] > 0) rectangle.upper[k] = rectangle.lower[k] + period[k];
  return rectangle;
}

NodeValues Field::at_nodes(const Surface& surface) const {
  if (!is_constant()) require_chart(surface, "a formula or map (" + source() + ")");
  return values(surface.parameters(), parameter_rectangle(surface));
}

NodeValues Field::at_samples(const Surface& surface, const SampleSet& samples) const {
  if (!is_constant()) require_chart(surface, "a formula or map (" + source() + ")");
  const ParameterRectangle within = parameter_rectangle(surface);
  NodeValues values(samples.size());
  for (Index s = 0; s < values.size(); ++s)
    values[s] = (*this)(samples.parameters()[static_cast<std::size_t>(s)], within);
  return values;
}

WeightsAtSamples PairWeightsField::at_samples(const Surface& surface,
                                              const SampleSet& samples) const {
  const ParameterRectangle within = parameter_rectangle(surface);
  if (!is_constant()) require_chart(surface, "a formula or map");
  if (is_constant()) {
    const PairWeights weights = (*this)(within.lower, within);
    if (weights.w[0] != weights.w[1] || weights.w[0] != weights.w[2])
      require_chart(surface, "a weight that differs between 11, 12 and 22");
    return WeightsAtSamples({weights});
  }
  std::vector<PairWeights> weights;
  weights.reserve(static_cast<std::size_t>(samples.size()));
  for (const Vec2& parameter : samples.parameters()) weights.push_back((*this)(parameter, within));
  return WeightsAtSamples(std::move(weights));
}

}  // namespace deform
