#pragma once

#include <string>
#include <vector>

#include "deform/record/frame.h"
#include "deform/record/jet_terms.h"
#include "deform/record/trajectory.h"

namespace deform {

/// What can be said of every node of a surface: each term's energy density (the mean of the samples
/// there, by D_0, where the samples are not the nodes); where they are, curvature, how far a term's
/// normal is off, and the branch of its estimator; and what colliders press and rub with.
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
  std::vector<JetTermUse> terms_;
  std::vector<TrajectoryField> fields_;
  std::vector<std::vector<float>> values_;
  bool with_contact_ = false;
  NodeVectors estimates_;
};

}  // namespace deform
