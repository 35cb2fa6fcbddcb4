# Configures one part alone (-DSCREE_PARTS), checks that nothing else is there, builds it and runs its
# unit test. cmake -DSOURCE=scree's source -DPART=name -DBUILT=parts -DOTHERS=parts -DWORK=folder
#                 -DCOMPILER=c++ [-DSANITIZE=...] -P alone.cmake
# BUILT: the part and what it needs; OTHERS: all other parts.
cmake_minimum_required(VERSION 3.25)
foreach(variable SOURCE PART BUILT WORK COMPILER)
  if(NOT ${variable})
    message(FATAL_ERROR "alone.cmake needs -D${variable}=...")
  endif()
endforeach()
string(REPLACE "," ";" BUILT "${BUILT}")
string(REPLACE "," ";" OTHERS "${OTHERS}")
file(REMOVE_RECURSE ${WORK})

include(${CMAKE_CURRENT_LIST_DIR}/command.cmake)

set(ENV{CCACHE_BASEDIR} ${SOURCE})
set(ENV{CCACHE_NOHASHDIR} 1)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK} -G Ninja -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_CXX_COMPILER=${COMPILER} -DSCREE_PARTS=${PART} -DSCREE_TESTS=ON -DSCREE_SANITIZE=${SANITIZE})

# Libraries, and tests, of what was asked for and of nothing else.
file(STRINGS ${WORK}/build.ninja rules REGEX "^build [^:]*:")
list(JOIN rules "\n" rules)
foreach(part IN LISTS BUILT)
  if(NOT rules MATCHES "\nbuild libscree_${part}\\.a:")
    message(FATAL_ERROR "${PART} alone: no library of ${part}, which it needs")
  endif()
endforeach()
foreach(part IN LISTS OTHERS)
  if(rules MATCHES "(scree_${part}\\.dir/|libscree_${part}\\.a|bin/test_${part}_)[^\n]*")
    message(FATAL_ERROR "${PART} alone: ${part} is configured too: ${CMAKE_MATCH_0}")
  endif()
endforeach()
if(rules MATCHES "hourglass")
  message(FATAL_ERROR "${PART} alone: the game is configured too")
endif()

# Packages that only other parts use (the benches have their own) are not even looked for.
file(READ ${WORK}/CMakeCache.txt cache)
foreach(pair platform:glfw3_DIR gpu:GLAD_PROGRAM assets:OpenImageIO_DIR overlay:IMGUI_VERSION)
  string(REGEX MATCH "^([a-z]+):(.*)$" unused ${pair})
  set(user ${CMAKE_MATCH_1})
  set(entry ${CMAKE_MATCH_2})
  if(cache MATCHES "\n${entry}:")
    set(found TRUE)
  else()
    set(found FALSE)
  endif()
  if(user IN_LIST BUILT AND NOT found)
    message(FATAL_ERROR "${PART} alone: ${user} is built, but ${entry} is not in the cache")
  elseif(NOT user IN_LIST BUILT AND found)
    message(FATAL_ERROR "${PART} alone: ${entry} was looked for, which only ${user} uses")
  endif()
endforeach()

run(${CMAKE_COMMAND} --build ${WORK} --target scree_${PART})
if(EXISTS ${SOURCE}/tests/${PART}/unit.cpp)
  run(${CMAKE_COMMAND} --build ${WORK} --target test_${PART}_unit)
  run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK} -R "^${PART}\\.unit$" --no-tests=error --output-on-failure)
endif()
message("${PART} alone: ${BUILT}")
