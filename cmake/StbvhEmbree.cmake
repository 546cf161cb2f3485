# Finds Embree, each major version that is installed, or the one that a project around this one has found already:
#   STBVH_EMBREE_MAJORS         those majors, the newest first
#   stbvh_embree_api_MAJOR      what is compiled for one links to it: headers, library, STBVH_EMBREE_MAJOR as a macro
#   STBVH_EMBREE_MAJOR, stbvh_embree_api   that of harness, tests and examples
# Sources learn of the version by plugin/embree_api.h alone.
set(STBVH_EMBREE_MAJOR "" CACHE STRING "Embree of harness and tests, 3 or 4; empty: 4 where it is installed, else 3")
set(least_embree_3 3.13)
set(least_embree_4 4)
set(STBVH_EMBREE_MAJORS)
set(given_embree_folder "${embree_DIR}")
foreach(major 4 3)
  add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/embree ${CMAKE_CURRENT_BINARY_DIR}/cmake/embree${major})
  set(embree_DIR "${given_embree_folder}" CACHE PATH "Folder of embree-config.cmake" FORCE)  # each find leaves its own
endforeach()

if(NOT STBVH_EMBREE_MAJOR)
  list(GET STBVH_EMBREE_MAJORS 0 STBVH_EMBREE_MAJOR)
endif()
if(NOT STBVH_EMBREE_MAJOR IN_LIST STBVH_EMBREE_MAJORS)
  message(FATAL_ERROR "Embree was not found (3.13 or later; Debian's package: libembree-dev), or not the major version that "
    "STBVH_EMBREE_MAJOR asks for. Where it lies in a folder of its own, give that as CMAKE_PREFIX_PATH.")
endif()
add_library(stbvh_embree_api ALIAS stbvh_embree_api_${STBVH_EMBREE_MAJOR})
