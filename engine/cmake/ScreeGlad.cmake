# Generates the OpenGL 4.5 core loader with glad (Debian: python3-glad), offline.
find_program(GLAD_PROGRAM glad REQUIRED)
set(glad_dir ${PROJECT_BINARY_DIR}/glad)
add_custom_command(
  OUTPUT ${glad_dir}/src/gl.c ${glad_dir}/include/glad/gl.h
  COMMAND ${GLAD_PROGRAM} --quiet --reproducible --out-path ${glad_dir} --api gl:core=4.5
          --extensions GL_KHR_debug c
  COMMENT "Generating the OpenGL 4.5 core loader" VERBATIM)
add_library(scree_glad STATIC ${glad_dir}/src/gl.c)
add_library(scree::scree_glad ALIAS scree_glad)
target_include_directories(scree_glad SYSTEM PUBLIC
  $<BUILD_INTERFACE:${glad_dir}/include> $<INSTALL_INTERFACE:include/scree/glad>)
