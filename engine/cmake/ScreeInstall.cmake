# cmake --install, and the package that find_package(scree) finds.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/scree)
set(data_dir ${CMAKE_INSTALL_DATADIR}/scree)

get_property(libraries GLOBAL PROPERTY SCREE_LIBRARIES)
if(TARGET scree_glad)
  list(APPEND libraries scree_glad)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/glad/include/ DESTINATION include/scree/glad)
endif()
install(TARGETS ${libraries} EXPORT scree_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT scree_targets NAMESPACE scree:: FILE screeTargets.cmake DESTINATION ${package_dir})

# Headers: all of an engine part, of a module its public one with those of its folder that this one
# includes. Shaders: those of the parts, and what they share.
foreach(part IN LISTS SCREE_BUILT ITEMS shared lib)
  if(EXISTS ${PROJECT_SOURCE_DIR}/engine/${part})
    install(DIRECTORY engine/${part} DESTINATION include/scree/engine FILES_MATCHING PATTERN "*.h")
  elseif(EXISTS ${PROJECT_SOURCE_DIR}/modules/${part})
    file(STRINGS ${PROJECT_SOURCE_DIR}/modules/${part}/${part}.h headers
         REGEX "^#include \"modules/${part}/")
    list(TRANSFORM headers REPLACE "^#include \"(.*)\".*" "\\1")
    install(FILES modules/${part}/${part}.h ${headers} DESTINATION include/scree/modules/${part})
  endif()
  if(EXISTS ${PROJECT_SOURCE_DIR}/shaders/${part})
    install(DIRECTORY shaders/${part} DESTINATION ${data_dir}/shaders)
  endif()
endforeach()
install(DIRECTORY shaders/shared DESTINATION include/scree/shaders FILES_MATCHING PATTERN "*.h")

if(TARGET hourglass)
  install(TARGETS hourglass DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(DIRECTORY content/levels content/models content/textures DESTINATION ${data_dir}/content)
endif()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/screeConfig.cmake.in
  ${PROJECT_BINARY_DIR}/screeConfig.cmake INSTALL_DESTINATION ${package_dir} PATH_VARS data_dir)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/screeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/screeConfig.cmake ${PROJECT_BINARY_DIR}/screeConfigVersion.cmake
              ${CMAKE_CURRENT_LIST_DIR}/ScreeDependencies.cmake DESTINATION ${package_dir})
