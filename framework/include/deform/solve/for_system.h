/// What an integrator keeps for its System.
#pragma once

#include <optional>

#include "deform/solve/system.h"

namespace deform {

/// An object that is made of a System when it is first asked for, and anew for another System.
template <class T>
class ForSystem {
 public:
  T& operator()(const System& system) {
    if (!object_ || of_ != &system) object_.emplace(system);
    of_ = &system;
    return *object_;
  }

 private:
  std::optional<T> object_;
  const System* of_ = nullptr;
};

}  // namespace deform
