# What `cmake --install` puts into a prefix, so that applications find it by CMake (stbvh::stbvh; the kernels alone:
# stbvh::kernels) or by pkg-config (docs/library.md). The prefix may be moved afterwards: nothing in it names it.
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/stbvh)
install(TARGETS stbvh EXPORT stbvh-targets
  LIBRARY COMPONENT Runtime NAMELINK_COMPONENT Development
  FILE_SET HEADERS COMPONENT Development)
set_target_properties(stbvh_kernels PROPERTIES EXPORT_NAME kernels)
install(TARGETS stbvh_kernels EXPORT stbvh-targets ARCHIVE COMPONENT Development)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/kernels/include/ DESTINATION ${STBVH_KERNELS_INCLUDEDIR} COMPONENT Development)
install(EXPORT stbvh-targets NAMESPACE stbvh:: DESTINATION ${package_folder} COMPONENT Development)

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/stbvh-config.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/stbvh-config.cmake INSTALL_DESTINATION ${package_folder}
  NO_SET_AND_CHECK_MACRO)
# As the soname: before 1.0 each minor version may break programs.
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/stbvh-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/stbvh-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/stbvh-config-version.cmake
  DESTINATION ${package_folder} COMPONENT Development)

# Embree has no .pc file that could be required: its folders and its library are named here.
set(pc_includedir "\${prefix}")
cmake_path(APPEND pc_includedir ${CMAKE_INSTALL_INCLUDEDIR})  # an absolute folder replaces the prefix
set(pc_libdir "\${prefix}")
cmake_path(APPEND pc_libdir ${CMAKE_INSTALL_LIBDIR})
cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX BASE_DIRECTORY ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig
  OUTPUT_VARIABLE pc_prefix)
get_target_property(embree_include_folders embree INTERFACE_INCLUDE_DIRECTORIES)
cmake_path(GET EMBREE_LIBRARY PARENT_PATH embree_library_folder)
list(REMOVE_ITEM embree_include_folders ${CMAKE_C_IMPLICIT_INCLUDE_DIRECTORIES})
list(TRANSFORM embree_include_folders PREPEND " -I" OUTPUT_VARIABLE pc_embree_cflags)
string(JOIN "" pc_embree_cflags ${pc_embree_cflags})
cmake_path(NORMAL_PATH embree_library_folder)
set(pc_embree_libs -lembree3)
if(NOT embree_library_folder IN_LIST CMAKE_C_IMPLICIT_LINK_DIRECTORIES)
  string(PREPEND pc_embree_libs "-L${embree_library_folder} ")
endif()
foreach(name stbvh stbvh-kernels)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${name}.pc.in ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT Development)
endforeach()

install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT Runtime)
