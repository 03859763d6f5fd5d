/// What nodes bear of a load on some part of the surface.
#pragma once

#include <deform/plugin/setup.h>
#include <deform/surface/surface.h>

namespace deform {

/// (N) A_a / Σ A with the area A_a that the selection takes of each node, of the surface that mass
/// goes by. Throws InputError where it takes none.
inline NodeValues area_shares(const NodeSelection& where, const Setup& setup) {
  const Surface& surface = setup.surface();
  const NodeValues taken =
      select_areas(surface, where).cwiseProduct(setup.areas().cwiseQuotient(surface.areas()));
  return taken / taken.sum();
}

}  // namespace deform
