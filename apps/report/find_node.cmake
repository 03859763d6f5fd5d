# The node that builds and tests the page. Debian 12's is too old for it: then npm gets another one,
# into the build tree. Sets DEFORM_NODE, and with_node, what commands that need it begin with.
set(wanted_node 20.19)
find_program(DEFORM_NODE node)
set(with_node "")
set(version "0")
if(DEFORM_NODE)
  execute_process(COMMAND ${DEFORM_NODE} --version OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE)
  string(REPLACE "v" "" version "${version}")
endif()

if(version VERSION_LESS wanted_node)
  set(machine x64)
  if(CMAKE_HOST_SYSTEM_PROCESSOR STREQUAL "aarch64")
    set(machine arm64)
  endif()
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/node)
  set(own ${folder}/node_modules/node-linux-${machine}/bin)
  if(NOT EXISTS ${own}/node)
    message(STATUS "node ${version} is too old for the page for reports: getting another one with npm")
    execute_process(COMMAND ${DEFORM_NPM} install --silent --no-save --no-audit --no-fund
      --prefix ${folder} node-linux-${machine}@22 RESULT_VARIABLE failed)
    if(failed)
      message(FATAL_ERROR "npm could not get node ${wanted_node} or newer, which the page for reports "
        "needs. Install it, or configure with -DDEFORM_BUILD_REPORT=OFF to build without the page.")
    endif()
  endif()
  set(DEFORM_NODE ${own}/node CACHE FILEPATH "" FORCE)
endif()

get_filename_component(node_folder ${DEFORM_NODE} DIRECTORY)
set(with_node ${CMAKE_COMMAND} -E env "PATH=${node_folder}:$ENV{PATH}")
