/// Where linear solvers come from.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "deform/solve/model_parts.h"

namespace deform {

/// Makes solvers for all matrices of a System, which share what has been said of them.
class SolverSource {
 public:
  SolverSource(MakeSolvers make)
      : make_(std::move(make)), said_(std::make_shared<std::set<std::string>>()) {}

  /// A fresh object of each solver to choose from.
  [[nodiscard]] std::vector<Named<LinearSolver>> operator()() const { return make_(); }
  /// Whether a message is one that nobody has said yet: what is so at one matrix mostly is at the
  /// next.
  [[nodiscard]] bool is_new(const std::string& message) const {
    return said_->insert(message).second;
  }

 private:
  MakeSolvers make_;
  std::shared_ptr<std::set<std::string>> said_;
};

}  // namespace deform
