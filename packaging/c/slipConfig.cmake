# find_package(slip): the targets slip::slip (shared) and slip::static.
get_filename_component(_slip_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET slip::slip)
  add_library(slip::slip SHARED IMPORTED)
  set_target_properties(slip::slip PROPERTIES
    IMPORTED_LOCATION "${_slip_prefix}/lib/libslip.so"
    IMPORTED_SONAME "libslip.so.0"
    INTERFACE_INCLUDE_DIRECTORIES "${_slip_prefix}/include")
  add_library(slip::static STATIC IMPORTED)
  set_target_properties(slip::static PROPERTIES
    IMPORTED_LOCATION "${_slip_prefix}/lib/libslip.a"
    INTERFACE_INCLUDE_DIRECTORIES "${_slip_prefix}/include"
    INTERFACE_LINK_LIBRARIES "gcc_s;util;rt;pthread;m;dl")
endif()
unset(_slip_prefix)
