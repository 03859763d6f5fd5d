/// Random fields, the same in every run.
#pragma once

#include <random>

#include "deform/types.h"

namespace deform::test {

/// (n × 3), each component between −1 and 1.
inline NodeVectors random_vectors(Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return NodeVectors::NullaryExpr(n, 3, [&] { return uniform(random); });
}

}  // namespace deform::test
