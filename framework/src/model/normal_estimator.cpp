#include "deform/model/normal_estimator.h"

#include <algorithm>

#include "deform/error.h"

namespace deform {

NormalEstimator::~NormalEstimator() = default;

std::vector<std::string> NormalEstimator::branches() const { return {}; }

void NormalEstimator::branch(const GeometryBlock& /*lagged*/, Pair /*ij*/,
                             std::span<std::uint8_t> out) const {
  if (!branches().empty()) {
    throw PluginFailure("a normal estimator names branches, but does not tell which one is taken");
  }
  std::fill(out.begin(), out.end(), std::uint8_t{0});
}

}  // namespace deform
