#[=======================================================================[.rst:
FindSuiteSparse
---------------

Finds the parts of SuiteSparse that ship without a CMake configuration, as Debian lays them out
(headers in ``<prefix>/include/suitesparse``).

Components: ``CHOLMOD``, ``UMFPACK``; both, where none is named. UMFPACK brings CHOLMOD with it, which it
uses for orderings.

Imported targets
  ``SuiteSparse::CHOLMOD``, ``SuiteSparse::UMFPACK``: with all that they need.
  ``SuiteSparse::Config``, ``SuiteSparse::AMD``, ``SuiteSparse::CAMD``, ``SuiteSparse::COLAMD``,
  ``SuiteSparse::CCOLAMD``: their parts.

Result variables
  ``SuiteSparse_FOUND``, ``SuiteSparse_VERSION``, ``SuiteSparse_<component>_FOUND``

Hint
  ``SuiteSparse_ROOT``: prefix of an installation in an unusual place.

The shared libraries name BLAS, LAPACK and METIS themselves; static ones, which do not, are not supported.
#]=======================================================================]

include(FindPackageHandleStandardArgs)

set(_suitesparse_package libsuitesparse-dev)
if(NOT SuiteSparse_FIND_COMPONENTS)
  set(SuiteSparse_FIND_COMPONENTS CHOLMOD UMFPACK)
  set(SuiteSparse_FIND_REQUIRED_CHOLMOD TRUE)
  set(SuiteSparse_FIND_REQUIRED_UMFPACK TRUE)
endif()

# One part: <part> <header> <library> [parts that it needs...]
# Sets _suitesparse_<part>_missing to what was not found, empty when all is there.
macro(_suitesparse_find part header library)
  find_path(SuiteSparse_${part}_INCLUDE_DIR NAMES ${header} PATH_SUFFIXES suitesparse)
  find_library(SuiteSparse_${part}_LIBRARY NAMES ${library})
  mark_as_advanced(SuiteSparse_${part}_INCLUDE_DIR SuiteSparse_${part}_LIBRARY)
  set(_suitesparse_${part}_needs ${ARGN})
  set(_suitesparse_${part}_missing "")
  if(NOT SuiteSparse_${part}_INCLUDE_DIR)
    list(APPEND _suitesparse_${part}_missing ${header})
  endif()
  if(NOT SuiteSparse_${part}_LIBRARY)
    list(APPEND _suitesparse_${part}_missing lib${library})
  endif()
  foreach(_suitesparse_need IN LISTS _suitesparse_${part}_needs)
    list(APPEND _suitesparse_${part}_missing ${_suitesparse_${_suitesparse_need}_missing})
  endforeach()
  list(REMOVE_DUPLICATES _suitesparse_${part}_missing)
endmacro()

# In the order of their needs.
set(_suitesparse_parts Config AMD CAMD COLAMD CCOLAMD CHOLMOD UMFPACK)
_suitesparse_find(Config SuiteSparse_config.h suitesparseconfig)
_suitesparse_find(AMD amd.h amd Config)
_suitesparse_find(CAMD camd.h camd Config)
_suitesparse_find(COLAMD colamd.h colamd Config)
_suitesparse_find(CCOLAMD ccolamd.h ccolamd Config)
_suitesparse_find(CHOLMOD cholmod.h cholmod Config AMD CAMD COLAMD CCOLAMD)
_suitesparse_find(UMFPACK umfpack.h umfpack Config AMD CHOLMOD)

unset(SuiteSparse_VERSION)
if(SuiteSparse_Config_INCLUDE_DIR)
  file(STRINGS "${SuiteSparse_Config_INCLUDE_DIR}/SuiteSparse_config.h" _suitesparse_lines
       REGEX "^[ \t]*#[ \t]*define[ \t]+SUITESPARSE_(MAIN|SUB|SUBSUB)_VERSION[ \t]+[0-9]+")
  set(_suitesparse_numbers "")
  foreach(_suitesparse_part IN ITEMS MAIN SUB SUBSUB)
    if("${_suitesparse_lines}" MATCHES "SUITESPARSE_${_suitesparse_part}_VERSION[ \t]+([0-9]+)")
      list(APPEND _suitesparse_numbers ${CMAKE_MATCH_1})
    endif()
  endforeach()
  list(JOIN _suitesparse_numbers "." SuiteSparse_VERSION)
endif()

set(_suitesparse_missing "")
foreach(_suitesparse_component IN LISTS SuiteSparse_FIND_COMPONENTS)
  set(SuiteSparse_${_suitesparse_component}_FOUND FALSE)
  if(NOT _suitesparse_component MATCHES "^(CHOLMOD|UMFPACK)$")
    list(APPEND _suitesparse_missing "component ${_suitesparse_component} (known: CHOLMOD, UMFPACK)")
  elseif(_suitesparse_${_suitesparse_component}_missing)
    list(APPEND _suitesparse_missing ${_suitesparse_${_suitesparse_component}_missing})
  else()
    set(SuiteSparse_${_suitesparse_component}_FOUND TRUE)
  endif()
endforeach()
list(REMOVE_DUPLICATES _suitesparse_missing)

unset(_suitesparse_reason)
if(_suitesparse_missing)
  list(JOIN _suitesparse_missing ", " _suitesparse_reason)
  set(_suitesparse_reason
      "not found: ${_suitesparse_reason}. On Debian, install ${_suitesparse_package} (and \
libopenblas-pthread-dev for a fast BLAS), or run scripts/setup. An installation in an unusual place: \
set SuiteSparse_ROOT.")
endif()

find_package_handle_standard_args(
  SuiteSparse
  REQUIRED_VARS SuiteSparse_Config_LIBRARY SuiteSparse_Config_INCLUDE_DIR
  VERSION_VAR SuiteSparse_VERSION
  HANDLE_COMPONENTS
  REASON_FAILURE_MESSAGE "${_suitesparse_reason}")

if(SuiteSparse_FOUND)
  foreach(_suitesparse_part IN LISTS _suitesparse_parts)
    if(NOT _suitesparse_${_suitesparse_part}_missing AND NOT TARGET SuiteSparse::${_suitesparse_part})
      add_library(SuiteSparse::${_suitesparse_part} UNKNOWN IMPORTED)
      set_target_properties(
        SuiteSparse::${_suitesparse_part}
        PROPERTIES IMPORTED_LOCATION "${SuiteSparse_${_suitesparse_part}_LIBRARY}"
                   INTERFACE_INCLUDE_DIRECTORIES "${SuiteSparse_${_suitesparse_part}_INCLUDE_DIR}")
      list(TRANSFORM _suitesparse_${_suitesparse_part}_needs PREPEND SuiteSparse::)
      set_property(TARGET SuiteSparse::${_suitesparse_part}
                   PROPERTY INTERFACE_LINK_LIBRARIES ${_suitesparse_${_suitesparse_part}_needs})
    endif()
  endforeach()
endif()

foreach(_suitesparse_part IN LISTS _suitesparse_parts)
  unset(_suitesparse_${_suitesparse_part}_missing)
  unset(_suitesparse_${_suitesparse_part}_needs)
endforeach()
unset(_suitesparse_parts)
unset(_suitesparse_part)
unset(_suitesparse_need)
unset(_suitesparse_component)
unset(_suitesparse_missing)
unset(_suitesparse_reason)
unset(_suitesparse_lines)
unset(_suitesparse_numbers)
unset(_suitesparse_package)
