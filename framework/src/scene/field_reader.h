#pragma once

#include <filesystem>

#include "scene/plain_reader.h"

namespace deform {

/// Where a file lies that a scene in `folder` names. Throws InputError where that is not UTF-8:
/// the completed scene could not name it.
[[nodiscard]] std::filesystem::path scene_file(const std::filesystem::path& folder,
                                               const std::filesystem::path& file);

/// Reads a value that may vary over the surface: a number, {"formula": "…"} or {"map": file}. The
/// map's file name starts from `folder`, and becomes absolute in the JSON, too.
std::optional<Field> read_field(Json& json, const ValuePlace& place,
                                const std::filesystem::path& folder, PlainReader& reader);

/// The same for weights: one of these for all pairs, or [[11, 12], [21, 22]] with equal 12 and 21.
std::optional<PairWeightsField> read_weights_field(Json& json, const ValuePlace& place,
                                                   const std::filesystem::path& folder,
                                                   PlainReader& reader);

}  // namespace deform
