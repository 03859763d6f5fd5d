# Headers that nearly every source of a target includes, parsed once: it takes a third to a half off the time of a build.
# Sources include what they need all the same; the linter parses them without.
set(DEFORM_STANDARD_HEADERS
  <algorithm> <array> <cmath> <cstddef> <cstdint> <filesystem> <functional> <limits> <memory> <optional> <span>
  <stdexcept> <string> <string_view> <utility> <variant> <vector> <Eigen/Core> <Eigen/Geometry>)

# deform_precompile_plugins(NAME): what plugins of this folder are to be compiled with, `PRECOMPILED NAME`. A library of
# one empty source, with the flags of a plugin and those of the folder: one set of parsed headers for all of them.
function(deform_precompile_plugins name)
  file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp CONTENT "")
  add_library(${name} STATIC ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE deform::framework deform_warnings)
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  target_precompile_headers(${name} PRIVATE ${DEFORM_STANDARD_HEADERS} <deform/plugin/descriptor.h>)
endfunction()
