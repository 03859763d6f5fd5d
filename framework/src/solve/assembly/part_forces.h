/// Which part of a model spoils a sum, to name it in messages.
#pragma once

#include <string>

#include "deform/solve/sparse_matrix.h"
#include "deform/solve/state.h"
#include "deform/types.h"

#include "solve/assembly/assembly.h"

namespace deform {

/// Forces of one energy term, or of all force fields, at a state (N × 3) [N]. Throws NotFinite.
[[nodiscard]] NodeVectors internal_force(Assembly& assembly, std::size_t term, const State& state);
[[nodiscard]] NodeVectors external_force(Assembly& assembly, const State& state);
/// Makes k the lagged operator of one term at a state, and adds its constant part to c.
void lagged_force(Assembly& assembly, std::size_t term, const State& state, SparseMatrix& k,
                  NodeVectors& c);
/// Name of the energy term or force field with the largest force at a node.
[[nodiscard]] std::string largest_force_at(Assembly& assembly, Index node, const State& state);

/// Where a sum has a number that is not finite: asks each part by itself, and throws the NotFinite
/// of the guilty one.
[[noreturn]] void throw_force_not_finite(Assembly& assembly, const State& state,
                                         const NodeVectors& force);
[[noreturn]] void throw_lagged_not_finite(Assembly& assembly, const State& state);

}  // namespace deform
