# Warnings and flags of our own targets, in one place.
function(cbr_flags target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion)
  # GCC 12 sees overlaps in string concatenation that are not there (GCC bug 105651); in a precompiled header it no longer knows
  # that the standard library's own lines are to be left alone, and sees more of the kind.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${target} PRIVATE -Wno-restrict $<$<BOOL:${CBR_PRECOMPILE}>:-Wno-stringop-overflow;-Wno-array-bounds>)
  endif()
  # GCC's collector walks through all of a precompiled header each time. Without it a source takes some 40 MB more.
  if(CBR_PRECOMPILE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE --param=ggc-min-expand=400)
  endif()
  if(CBR_NATIVE)
    target_compile_options(${target} PRIVATE -march=native)
  endif()
endfunction()

# Libraries and programs, not tests: checks of the stack and of the C library's buffers. The latter need an optimised build.
function(cbr_harden target)
  target_compile_options(${target} PRIVATE -fstack-protector-strong
    $<$<CONFIG:Release>:-U_FORTIFY_SOURCE> $<$<CONFIG:Release>:-D_FORTIFY_SOURCE=3>)
endfunction()

# Tests spend their time in the libraries, which keep the build's own flags. Builds through a compiler cache keep them for
# tests too: they find again what was compiled before.
if(CBR_PRECOMPILE)
  set(CBR_TEST_FLAGS "$<$<CONFIG:Release>:-O0>")
endif()

# cbr_target(NAME [cbr_common_precompiled | cbr_test_precompiled]): flags, and which precompiled headers (cmake/precompiled).
# Those of tests bring the flags of tests, as the compiler takes precompiled headers only for the same flags.
function(cbr_target target)
  cbr_flags(${target})
  if(NOT "cbr_test_precompiled" IN_LIST ARGN)
    cbr_harden(${target})
  endif()
  if(CBR_PRECOMPILE)
    set(headers cbr_scene_precompiled ${ARGN})
    list(GET headers -1 headers)
    target_precompile_headers(${target} REUSE_FROM ${headers})
    if(headers STREQUAL cbr_test_precompiled)
      target_compile_options(${target} PRIVATE ${CBR_TEST_FLAGS})
    endif()
  endif()
endfunction()

# cbr_join_folders(NAME): the sources of each folder of a library are compiled at once, as their templates are the same ones
# (docs/decisions/build-time.md). So names in a folder's unnamed namespaces differ. Sources with options of their own stay apart.
option(CBR_JOIN_FOLDERS "Compile the sources of each folder at once; OFF: one by one, for frequent small changes" ${CBR_PRECOMPILE})
function(cbr_join_folders target)
  if(NOT CBR_JOIN_FOLDERS OR NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")  # g++ 12 gains nothing
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    cmake_path(GET source PARENT_PATH folder)
    string(REPLACE "/" "_" group "${folder}_")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()

# The linker keeps the first copy of an inline function or template that it meets. Of the copies in a test's objects (-O0) and in
# our libraries (-O3) that is the library's: they stand first, and whole, so that none of them is left out.
function(cbr_prefer_libraries target)
  set(found)
  set(open ${target})
  while(open)
    list(POP_FRONT open library)
    get_target_property(next ${library} LINK_LIBRARIES)
    foreach(name IN LISTS next)
      string(REGEX REPLACE "^cbr::" "cbr_" name "${name}")
      if(name MATCHES "^cbr_" AND NOT name IN_LIST found)
        list(APPEND found ${name})
        list(APPEND open ${name})
      endif()
    endforeach()
  endwhile()
  foreach(part IN ITEMS dynamics skinner reducer common)
    if(cbr_${part} IN_LIST found)
      target_link_options(${target} PRIVATE LINKER:--whole-archive,$<TARGET_FILE:cbr_${part}>,--no-whole-archive)
    endif()
  endforeach()
endfunction()

# Sources of tests are compiled thirty at once, which takes less than half of the time (docs/decisions/build-time.md). So each
# has a namespace of its own, cbr::NAME_OF_THE_FILE.
# cbr_test(NAME SOURCES a.cpp ... LIBRARIES cbr_common [OPTIMISED] [READ_TREE a.cpp ...]): one GoogleTest program, one ctest entry
# a test. OPTIMISED: the tests compute for long by themselves, ten seconds and more at -O0, and have the flags of libraries.
# READ_TREE names the sources that read files of this tree. Not joined, they alone are compiled with its path, so that all others
# can come from a compiler cache that another clone filled.
function(cbr_test name)
  cmake_parse_arguments(ARG "OPTIMISED" "" "SOURCES;LIBRARIES;READ_TREE" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} GTest::gtest_main)
  set(tree CBR_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(ARG_READ_TREE AND CBR_JOIN_FOLDERS)
    target_compile_definitions(${name} PRIVATE ${tree})
  elseif(ARG_READ_TREE)
    set_source_files_properties(${ARG_READ_TREE} PROPERTIES COMPILE_DEFINITIONS ${tree})
  endif()
  if(ARG_OPTIMISED)
    cbr_target(${name})
  else()
    cbr_target(${name} cbr_test_precompiled)
  endif()
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${CBR_JOIN_FOLDERS} UNITY_BUILD_BATCH_SIZE 30)
  cbr_prefer_libraries(${name})
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600)
endfunction()

# cbr_program(cbr-reduce SOURCES main.cpp LIBRARIES cbr_reducer): a program, in <build>/bin, installed.
function(cbr_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} CLI11::CLI11)
  # CMake fills the path of libraries in the build with empty entries, for which the loader looks into the current folder. The
  # system's libraries need no path.
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin BUILD_WITH_INSTALL_RPATH ON)
  target_link_options(${name} PRIVATE -Wl,-z,relro,-z,now)
  cbr_target(${name})
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()
