# Defines the targets raypath::raypath (shared) and raypath::static.
get_filename_component(RAYPATH_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET raypath::raypath)
  add_library(raypath::raypath SHARED IMPORTED)
  set_target_properties(raypath::raypath PROPERTIES
    IMPORTED_LOCATION "${RAYPATH_PREFIX}/lib/libraypath.so.@VERSION@"
    IMPORTED_SONAME "libraypath.so.@ABI@"
    INTERFACE_INCLUDE_DIRECTORIES "${RAYPATH_PREFIX}/include")

  add_library(raypath::static STATIC IMPORTED)
  set_target_properties(raypath::static PROPERTIES
    IMPORTED_LOCATION "${RAYPATH_PREFIX}/lib/libraypath.a"
    INTERFACE_INCLUDE_DIRECTORIES "${RAYPATH_PREFIX}/include"
    INTERFACE_LINK_LIBRARIES "@STATIC_LIBRARIES@")
endif()
