#include "alike_rows.h"

#include <utility>

namespace multigrid {

void AlikeRows::add(std::span<const Entry> row) {
  const std::int32_t first = row.empty() ? 0 : row.front().column;
  std::vector<std::pair<std::int32_t, float>> key;
  for (const Entry& e : row) key.emplace_back(e.column - first, e.weight);
  const auto [at, is_new] = kinds_.try_emplace(std::move(key));
  if (is_new) {
    at->second.begin = static_cast<std::uint32_t>(shared_.size());
    for (const auto& [column, weight] : at->first) shared_.push_back({column, weight});
    at->second.end = static_cast<std::uint32_t>(shared_.size());
  }
  first_.push_back(first);
  kind_.push_back(at->second);
}

}  // namespace multigrid
