# Builds and runs one outside project against the installed tree, as a user of Scree would.
# cmake -DPROJECT=folder -DPREFIX=installed -DWORK=folder -DCOMPILER=c++ [-DSOURCE=scree's source]
#       [-DFLAGS=...] -P run.cmake
cmake_minimum_required(VERSION 3.25)
foreach(variable PROJECT PREFIX WORK COMPILER SOURCE)
  if(NOT ${variable})
    message(FATAL_ERROR "run.cmake needs -D${variable}=...")
  endif()
endforeach()
file(REMOVE_RECURSE ${WORK})

include(${CMAKE_CURRENT_LIST_DIR}/command.cmake)

run(${CMAKE_COMMAND} -S ${PROJECT} -B ${WORK} -G Ninja -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_PREFIX_PATH=${PREFIX} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS}
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON)

# Headers and libraries come from the installed tree alone.
file(READ ${WORK}/compile_commands.json commands)
file(READ ${WORK}/build.ninja links)
foreach(text commands links)
  string(REPLACE ${WORK} "" rest "${${text}}")
  string(REPLACE ${PREFIX} "" rest "${rest}")
  string(REPLACE ${PROJECT} "" rest "${rest}")
  string(FIND "${rest}" "-I${SOURCE}" include)
  string(FIND "${rest}" "-isystem ${SOURCE}" system)
  string(FIND "${rest}" "libscree_" library)
  if(NOT include EQUAL -1 OR NOT system EQUAL -1)
    message(FATAL_ERROR "the outside project includes Scree's source folder ${SOURCE}")
  endif()
  if(text STREQUAL "links" AND library EQUAL -1)
    message(FATAL_ERROR "the outside project links no library of Scree")
  endif()
endforeach()

run(${CMAKE_COMMAND} --build ${WORK})
run(${WORK}/reuse)
message("${output}")
