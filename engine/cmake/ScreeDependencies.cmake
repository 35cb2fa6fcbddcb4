# Finds what the parts in SCREE_BUILT link: in the build itself, and in the installed package.
# scree_find(package ...) is the includer's: a plain find_package, or find_dependency.
scree_find(TBB)
scree_find(fmt)
scree_find(spdlog)
if("platform" IN_LIST SCREE_BUILT)
  scree_find(glfw3)
  scree_find(OpenGL COMPONENTS EGL)
  scree_find(nlohmann_json)
endif()
if("assets" IN_LIST SCREE_BUILT)
  scree_find(nlohmann_json)
  scree_find(OpenImageIO)
  # Debian's package names OpenCV's include folder without depending on it; CMake refuses a target
  # with a folder that does not exist.
  get_target_property(scree_oiio_folders OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
  list(FILTER scree_oiio_folders EXCLUDE REGEX opencv)
  set_target_properties(OpenImageIO::OpenImageIO PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${scree_oiio_folders}")
endif()
if("app" IN_LIST SCREE_BUILT)
  scree_find(CLI11)
endif()
if("overlay" IN_LIST SCREE_BUILT)
  scree_find(PkgConfig)
  pkg_check_modules(IMGUI REQUIRED IMPORTED_TARGET imgui)
endif()
