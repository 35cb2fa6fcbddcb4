# cmake --install, and the package that find_package(scree) finds.
include(CMakePackageConfigHelpers)
get_property(libraries GLOBAL PROPERTY SCREE_LIBRARIES)
install(TARGETS ${libraries} scree_glad EXPORT scree_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT scree_targets NAMESPACE scree:: FILE screeTargets.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scree)
install(DIRECTORY engine modules DESTINATION include/scree FILES_MATCHING PATTERN "*.h" PATTERN cmake EXCLUDE)
install(DIRECTORY shaders/shared DESTINATION include/scree/shaders FILES_MATCHING PATTERN "*.h")
install(DIRECTORY ${PROJECT_BINARY_DIR}/glad/include/ DESTINATION include/scree/glad)
install(DIRECTORY shaders DESTINATION ${CMAKE_INSTALL_DATADIR}/scree)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/screeConfig.cmake.in
  ${PROJECT_BINARY_DIR}/screeConfig.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scree)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/screeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/screeConfig.cmake ${PROJECT_BINARY_DIR}/screeConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scree)
