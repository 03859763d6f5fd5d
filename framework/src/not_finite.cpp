#include "not_finite.h"

#include <utility>

namespace deform {

NotFinite::NotFinite(const std::string& reason, Index node, std::string part)
    : Error(ExitCode::diverged, reason), node_(node), part_(std::move(part)) {}
NotFinite::~NotFinite() = default;

Diverged NotFinite::at_step(long step, const std::string& caller) const {
  return {what(), step, static_cast<long>(node_), part_.empty() ? caller : part_};
}

Index first_not_finite(const Eigen::Ref<const Eigen::MatrixXd>& values) {
  if (values.allFinite()) return -1;
  Index row = 0;
  while (values.row(row).allFinite()) ++row;
  return row;
}

void require_finite(const Eigen::Ref<const Eigen::MatrixXd>& values, const char* what,
                    const std::string& origin, const std::string& part) {
  const Index node = first_not_finite(values);
  if (node >= 0)
    throw NotFinite(std::string(what) + " of " + origin + " is not finite", node, part);
}

}  // namespace deform
