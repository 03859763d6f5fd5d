/// Numbers that are not finite, or cannot be had: whose they are, and at which node.
#pragma once

#include <string>

#include "deform/error.h"
#include "deform/types.h"

namespace deform {

/// Part of a model gave a number that is not finite, or a solver none. A System throws it, which
/// counts no steps; whoever does makes it a Diverged.
class NotFinite : public Error {
 public:
  /// `part`: its name within the model; empty for whoever called the System.
  NotFinite(const std::string& reason, Index node, std::string part);
  ~NotFinite() override;

  [[nodiscard]] const std::string& part() const noexcept { return part_; }
  /// `caller`: who to name where the part is who called.
  [[nodiscard]] Diverged at_step(long step, const std::string& caller) const;

 private:
  Index node_;
  std::string part_;
};

/// The first row with a number that is not finite; −1 where there is none.
[[nodiscard]] Index first_not_finite(const Eigen::Ref<const Eigen::MatrixXd>& values);

/// Throws NotFinite when one of `values` (a row a node) is not finite: "`what` of `origin` is not
/// finite".
void require_finite(const Eigen::Ref<const Eigen::MatrixXd>& values, const char* what,
                    const std::string& origin, const std::string& part);

}  // namespace deform
