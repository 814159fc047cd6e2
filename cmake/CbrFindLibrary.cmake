# Debian 12 ships no CMake config for these libraries: a header, one or more libraries, one imported target.
include(FindPackageHandleStandardArgs)

function(cbr_find_library package target)
  cmake_parse_arguments(ARG "" "HEADER" "NAMES;SUFFIXES" ${ARGN})
  find_path(${package}_INCLUDE_DIR NAMES ${ARG_HEADER} PATH_SUFFIXES ${ARG_SUFFIXES})
  set(variables ${package}_INCLUDE_DIR)
  set(libraries)
  foreach(name IN LISTS ARG_NAMES)
    find_library(${package}_${name}_LIBRARY NAMES ${name} PATH_SUFFIXES openblas-pthread)
    list(APPEND variables ${package}_${name}_LIBRARY)
    list(APPEND libraries ${${package}_${name}_LIBRARY})
  endforeach()
  find_package_handle_standard_args(${package} REQUIRED_VARS ${variables})
  mark_as_advanced(${variables})
  set(${package}_FOUND ${${package}_FOUND} PARENT_SCOPE)
  if(${package}_FOUND AND NOT TARGET ${target})
    add_library(${target} INTERFACE IMPORTED GLOBAL)
    set_target_properties(${target} PROPERTIES
      INTERFACE_INCLUDE_DIRECTORIES "${${package}_INCLUDE_DIR}"
      INTERFACE_LINK_LIBRARIES "${libraries}")
  endif()
endfunction()
