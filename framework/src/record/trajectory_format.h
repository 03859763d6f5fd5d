/// What the writer and the reader of trajectories share; the format is told at Trajectory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "deform/record/trajectory.h"

#include "json/json.h"

namespace deform::trajectory_format {

inline constexpr std::string_view kMagic = "deform trajectory 1\n";
inline constexpr std::size_t kMomentBytes = sizeof(std::int64_t) + sizeof(double);
/// Longer than any header that is written.
inline constexpr std::uint64_t kMostHeader = 1 << 20;

/// Up to and with so many of its fields.
[[nodiscard]] inline std::size_t bytes_of_frame(std::size_t nodes, std::size_t fields) {
  return kMomentBytes + nodes * (3 * sizeof(double) + fields * sizeof(float));
}

/// How a field is written in JSON.
[[nodiscard]] Json json_of(const TrajectoryField& field);
/// The reverse; throws a std::exception for anything else.
[[nodiscard]] TrajectoryField field_of(const Json& json);

}  // namespace deform::trajectory_format
