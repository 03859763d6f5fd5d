/// The energy terms on jets of a system and their estimated normals, as probes and outputs look at
/// them.
#pragma once

#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/solve/system.h"

namespace deform {

/// An energy term on jets and the sample set that it lives on; valid as long as its System.
struct JetTermUse {
  std::size_t number = 0;  ///< within System::energies()
  std::string name;
  const JetTerm* term = nullptr;
  const SampleSet* samples = nullptr;
};

/// All of them, in the order of System::energies().
[[nodiscard]] DEFORM_API std::vector<JetTermUse> jet_terms(const System& system);
/// Those that have a normal estimator.
[[nodiscard]] DEFORM_API std::vector<JetTermUse> terms_with_normal(const System& system);

/// What the term's estimator takes for the unit normal n_ij at each sample: coefficients of
/// `lagged`, applied to the jets of `now`. `normals` becomes (m × 3) [1], zero where the set cannot
/// compute r_ij. The term must have an estimator.
DEFORM_API void estimate_normals(const JetTermUse& use, const Geometry& lagged, const Geometry& now,
                                 Pair ij, NodeVectors& normals);

/// Directed angle [rad] between an estimated normal and another (0 to π: one on the wrong side of
/// the surface is wrong by more than π/2); NaN where one of them has no direction.
[[nodiscard]] DEFORM_API double angle_between(const Vec3& estimate, const Vec3& other);

/// Weighted mean and maximum of angles [rad].
class DEFORM_API Angles {
 public:
  /// Passes over an angle that is NaN.
  void add(double angle, double weight);
  [[nodiscard]] bool none() const { return !(weight_ > 0); }
  [[nodiscard]] double mean() const { return sum_ / weight_; }
  [[nodiscard]] double max() const { return max_; }

 private:
  double sum_ = 0, weight_ = 0, max_ = 0;
};

}  // namespace deform
