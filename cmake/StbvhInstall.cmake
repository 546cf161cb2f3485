# What `cmake --install` puts into a prefix, so that applications find it by CMake (stbvh::stbvh; the kernels alone:
# stbvh::kernels) or by pkg-config (docs/library.md). What belongs to one major version of Embree has names of its own, so
# that one prefix takes both. The prefix may be moved afterwards: nothing in it names it.
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/stbvh)
set(parts kernels)
foreach(major ${STBVH_EMBREE_MAJORS})
  install(TARGETS stbvh_${major} EXPORT stbvh-embree${major}-targets
    LIBRARY COMPONENT Runtime${major} NAMELINK_COMPONENT Development
    FILE_SET HEADERS COMPONENT Development)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT Runtime${major})
  list(APPEND parts embree${major})
endforeach()
set_target_properties(stbvh_kernels PROPERTIES EXPORT_NAME kernels)
install(TARGETS stbvh_kernels EXPORT stbvh-kernels-targets ARCHIVE COMPONENT Development)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/kernels/include/ DESTINATION ${STBVH_KERNELS_INCLUDEDIR} COMPONENT Development)
foreach(part ${parts})
  install(EXPORT stbvh-${part}-targets NAMESPACE stbvh:: DESTINATION ${package_folder} COMPONENT Development)
endforeach()

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
foreach(major ${STBVH_EMBREE_MAJORS})
  set(library ${STBVH_LIBRARY_${major}})
  set(embree_include_folders ${EMBREE_${major}_INCLUDE_FOLDERS})
  set(embree_library_folder ${EMBREE_${major}_LIBRARY_FOLDER})
  list(REMOVE_ITEM embree_include_folders ${CMAKE_C_IMPLICIT_INCLUDE_DIRECTORIES})
  list(TRANSFORM embree_include_folders PREPEND " -I" OUTPUT_VARIABLE pc_embree_cflags)
  string(JOIN "" pc_embree_cflags ${pc_embree_cflags})
  cmake_path(NORMAL_PATH embree_library_folder)
  set(pc_embree_libs -lembree${major})
  if(NOT embree_library_folder IN_LIST CMAKE_C_IMPLICIT_LINK_DIRECTORIES)
    string(PREPEND pc_embree_libs "-L${embree_library_folder} ")
  endif()
  configure_file(${CMAKE_CURRENT_LIST_DIR}/stbvh.pc.in ${CMAKE_CURRENT_BINARY_DIR}/${library}.pc @ONLY)
  list(APPEND pc_files ${CMAKE_CURRENT_BINARY_DIR}/${library}.pc)
endforeach()
configure_file(${CMAKE_CURRENT_LIST_DIR}/stbvh-kernels.pc.in ${CMAKE_CURRENT_BINARY_DIR}/stbvh-kernels.pc @ONLY)
install(FILES ${pc_files} ${CMAKE_CURRENT_BINARY_DIR}/stbvh-kernels.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT Development)
