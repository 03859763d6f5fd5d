#pragma once

#include <string>
#include <vector>

#include "deform/record/frame.h"
#include "deform/record/jet_terms.h"
#include "deform/record/trajectory.h"

namespace deform {

/// What can be said of every node of a surface whose samples are its nodes: curvature, each term's
/// energy, how far its normal is off, and the branch of its estimator. Of other sample sets
/// nothing.
class NodeFields {
 public:
  explicit NodeFields(const System& system);
  [[nodiscard]] const std::vector<TrajectoryField>& fields() const { return fields_; }
  /// (N) values of each field; NaN where there is no figure. Valid until the next call.
  [[nodiscard]] const std::vector<std::vector<float>>& evaluate(const Frame& frame);

 private:
  void add_angles(const JetTermUse& use, const Frame& frame, std::vector<float>& values);
  static void add_branches(const JetTermUse& use, const Frame& frame, std::vector<float>& values);

  const SampleSet* curved_ = nullptr;  // the set that B is taken from; null: none on the nodes
  std::vector<JetTermUse> terms_;      // on the nodes
  std::vector<TrajectoryField> fields_;
  std::vector<std::vector<float>> values_;
  NodeVectors estimates_;
};

}  // namespace deform
