# Finds Embree: the one that a project around this one has found already, else the major that STBVH_EMBREE_MAJOR names,
# else 4 where it is installed, else 3.13. Its target is `embree` in both; sources learn of it by plugin/embree_api.h alone.
set(STBVH_EMBREE_MAJOR "" CACHE STRING "Major version of Embree, 3 or 4; empty: 4 where it is installed, else 3")
if(NOT TARGET embree)
  if(STBVH_EMBREE_MAJOR STREQUAL "4")
    find_package(embree 4 REQUIRED)
  elseif(NOT STBVH_EMBREE_MAJOR STREQUAL "3")
    find_package(embree 4 QUIET)
  endif()
  if(NOT embree_FOUND)
    find_package(embree 3.13 REQUIRED)
  endif()
endif()
add_compile_definitions(STBVH_EMBREE_MAJOR=${EMBREE_VERSION_MAJOR})
