/// Polygon meshes as files have them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <deform/surface/surface.h>

namespace mesh {
using deform::Index;

/// Vertices and polygons over them, as they were read: nothing is checked yet.
struct Polygons {
  deform::NodeVectors positions;  ///< (V × 3), in the file's unit
  deform::Faces faces;
  std::vector<std::string> group_names;  ///< of objects, groups and materials, each once
  std::vector<std::int32_t> group;       ///< of each polygon; −1: none
};

/// Reads OBJ (double precision), PLY, STL, OFF, glTF and GLB (single precision) by the file's
/// ending. Vertices at one place are made one where the format doubles them (STL, glTF). Throws
/// InputError that names the file and what is wrong with it.
[[nodiscard]] Polygons read_polygons(const std::filesystem::path& file);

/// Makes vertices at exactly the same place one, the first; returns how many others there were.
Index weld(Polygons& polygons);

}  // namespace mesh
