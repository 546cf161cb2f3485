# Debian packages, one for each part that is used alone: `cmake --workflow --preset package` (docs/library.md).
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL Development Preload)
if(STBVH_BUILD_HARNESS)
  list(APPEND CPACK_COMPONENTS_ALL Harness)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/package_documents.cmake)
set(CPACK_STBVH_DOCUMENTS ${CMAKE_CURRENT_LIST_DIR}/package)  # what that script reads
set(CPACK_STBVH_CHANGELOG ${PROJECT_SOURCE_DIR}/CHANGELOG.md)

set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "STBVH for Embree maintainers <maintainers@stbvh.invalid>")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)

foreach(major ${STBVH_EMBREE_MAJORS})
  list(APPEND CPACK_COMPONENTS_ALL Runtime${major})
  # As its soname: libstbvh0.1, libstbvh4-0.1.
  string(REGEX REPLACE "([0-9])$" "\\1-" library_package lib${STBVH_LIBRARY_${major}})
  string(APPEND library_package ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  set(CPACK_DEBIAN_RUNTIME${major}_PACKAGE_NAME ${library_package})
  set(CPACK_DEBIAN_RUNTIME${major}_PACKAGE_SECTION libs)
  set(CPACK_COMPONENT_RUNTIME${major}_DESCRIPTION
    "Shared library: moving triangle meshes as a user geometry of Embree ${major}.")
  list(APPEND library_packages "${library_package} (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
endforeach()

list(GET STBVH_EMBREE_MAJORS -1 least_major)
list(JOIN library_packages ", " library_packages)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libstbvh-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "${library_packages}, libembree-dev (>= ${least_embree_${least_major}}), libtbb-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Header, CMake package and pkg-config file of libstbvh.")

set(CPACK_DEBIAN_PRELOAD_PACKAGE_NAME stbvh-preload)
set(CPACK_DEBIAN_PRELOAD_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PRELOAD_PACKAGE_DEPENDS python3)
set(CPACK_COMPONENT_PRELOAD_DESCRIPTION
  "stbvh-run runs programs of Embree as they are, with their moving triangle
 meshes answered by STBVH.")

set(CPACK_DEBIAN_HARNESS_PACKAGE_NAME stbvh-harness)
set(CPACK_DEBIAN_HARNESS_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_HARNESS_PACKAGE_DEPENDS python3)
set(CPACK_DEBIAN_HARNESS_PACKAGE_RECOMMENDS "python3-matplotlib, python3-venv")
set(CPACK_COMPONENT_HARNESS_DESCRIPTION
  "stbvh-ab compares structures for motion blur in speed, memory and error, and
 renders through them; stbvh-preview shows their pictures in a window.")
include(CPack)
