# Build options and the compile flags that every target of Scree shares.
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, RelWithDebInfo or Debug" FORCE)
endif()
option(SCREE_TESTS "Build the tests and benches" ${PROJECT_IS_TOP_LEVEL})
option(SCREE_WERROR "Treat warnings as errors" ${PROJECT_IS_TOP_LEVEL})
option(SCREE_OSMESA "Build the OSMesa context maker" ON)
set(SCREE_SANITIZE "" CACHE STRING "Sanitizers: empty, address (ASan + UBSan) or thread (TSan)")
set_property(CACHE SCREE_SANITIZE PROPERTY STRINGS "" address thread)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# What every target compiles with. Contraction into fused multiply-add is off, so that a result
# does not depend on the machine.
add_library(scree_flags INTERFACE)
target_compile_options(scree_flags INTERFACE -ffp-contract=off -Wall -Wextra -Wshadow
  -Wnon-virtual-dtor -Wno-missing-field-initializers)
if(SCREE_WERROR)
  target_compile_options(scree_flags INTERFACE -Werror)
endif()
if(SCREE_SANITIZE STREQUAL "address")
  target_compile_options(scree_flags INTERFACE -fsanitize=address,undefined
    -fno-sanitize-recover=undefined -fno-omit-frame-pointer -g1)
  target_link_options(scree_flags INTERFACE -fsanitize=address,undefined)
  # GCC's flow analysis takes the checks for paths that the program has, and warns of these.
  target_compile_options(scree_flags INTERFACE -Wno-stringop-overflow -Wno-array-bounds
    -Wno-maybe-uninitialized)
elseif(SCREE_SANITIZE STREQUAL "thread")
  target_compile_options(scree_flags INTERFACE -fsanitize=thread -g1)
  target_link_options(scree_flags INTERFACE -fsanitize=thread)
  # TSan sees only the half of oneTBB that is in its headers, and takes that for races. They are included
  # in this file alone, which tells TSan in what order a loop's chunks run.
  set_source_files_properties(${PROJECT_SOURCE_DIR}/engine/core/parallel.cpp PROPERTIES
    COMPILE_OPTIONS -fno-sanitize=thread COMPILE_DEFINITIONS SCREE_SANITIZE_THREAD)
elseif(NOT SCREE_SANITIZE STREQUAL "")
  message(FATAL_ERROR "SCREE_SANITIZE is '${SCREE_SANITIZE}': allowed are '', 'address', 'thread'")
endif()
