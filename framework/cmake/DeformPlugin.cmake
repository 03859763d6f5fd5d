# deform_add_plugin(KIND NAME SOURCES file… [LIBRARIES target…] [INSTALL])
#
# Builds one plugin as a shared library KIND-NAME.so, the name by which the host finds it, with the framework's
# flags. In a project of one's own it lands in the current binary folder: give that to `deform --plugin-path`.
function(deform_add_plugin kind name)
  cmake_parse_arguments(PLUGIN "INSTALL" "OUTPUT_DIRECTORY" "SOURCES;LIBRARIES" ${ARGN})
  if(PLUGIN_UNPARSED_ARGUMENTS OR NOT PLUGIN_SOURCES)
    message(FATAL_ERROR "deform_add_plugin(KIND NAME SOURCES file… [LIBRARIES target…] [INSTALL])")
  endif()
  get_property(kinds GLOBAL PROPERTY DEFORM_PLUGIN_KINDS)
  if(NOT kind IN_LIST kinds)
    message(FATAL_ERROR "deform_add_plugin: '${kind}' is none of ${kinds}")
  endif()
  if(NOT name MATCHES "^[a-z][a-z0-9_]*$")
    message(FATAL_ERROR "deform_add_plugin: '${name}' must match [a-z][a-z0-9_]*")
  endif()
  set(target deform_${kind}_${name})
  add_library(${target} MODULE ${PLUGIN_SOURCES})
  target_link_libraries(${target} PRIVATE deform::framework ${PLUGIN_LIBRARIES})
  # Nothing but the descriptor is visible, so that two plugins cannot bind to each other's symbols.
  set_target_properties(${target} PROPERTIES PREFIX "" OUTPUT_NAME "${kind}-${name}" SUFFIX ".so"
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  if(PLUGIN_OUTPUT_DIRECTORY)
    set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PLUGIN_OUTPUT_DIRECTORY})
  else()
    set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
  endif()
  if(DEFORM_SANITIZERS)
    target_link_options(${target} PRIVATE -Wl,-z,nodelete)  # leak reports keep their module
  else()
    target_link_options(${target} PRIVATE -Wl,--no-undefined)  # a missing symbol shows now, not at load time
  endif()
  if(PLUGIN_INSTALL)
    set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/../..")
    install(TARGETS ${target} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/deform/plugins)
  endif()
endfunction()
