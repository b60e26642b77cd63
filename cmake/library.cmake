# libffprocams, shared and static, of the objects of all rooms, and the program, which sees the public headers alone.
get_property(objects DIRECTORY PROPERTY FFP_OBJECTS)
get_property(libraries DIRECTORY PROPERTY FFP_LIBRARIES)
list(REMOVE_DUPLICATES libraries)
get_property(modules DIRECTORY PROPERTY FFP_MODULES)
# By name: whoever links the archive may be a project without C, for which there is no OpenMP::OpenMP_C.
set(FFP_SYSTEM_LIBRARIES ${OpenMP_C_LIB_NAMES} ${CMAKE_DL_LIBS} m)
list(REMOVE_DUPLICATES FFP_SYSTEM_LIBRARIES)

foreach(kind shared static)
  string(TOUPPER ${kind} KIND)
  add_library(ffprocams_${kind} ${KIND} ${objects})
  set_target_properties(ffprocams_${kind} PROPERTIES OUTPUT_NAME ffprocams EXPORT_NAME ffprocams LINKER_LANGUAGE C)
  target_include_directories(ffprocams_${kind} PUBLIC "$<BUILD_INTERFACE:${FFP_INCLUDE}>")
  target_link_libraries(ffprocams_${kind} PRIVATE ${libraries})
  add_dependencies(ffprocams_${kind} ${modules})
endforeach()
# Before 1.0 a minor version may change the interface.
set_target_properties(ffprocams_shared PROPERTIES VERSION ${PROJECT_VERSION}
                      SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
target_link_libraries(ffprocams_shared PRIVATE OpenMP::OpenMP_C ${CMAKE_DL_LIBS} m)
target_link_libraries(ffprocams_static PRIVATE ${FFP_SYSTEM_LIBRARIES})
target_link_options(ffprocams_shared PRIVATE LINKER:--version-script=${PROJECT_SOURCE_DIR}/cmake/ffprocams.map)
# OpenMP's workers outlive a call: a host that unloads the library must not take their code away.
target_link_options(ffprocams_shared PRIVATE LINKER:-z,nodelete)
set_target_properties(ffprocams_shared PROPERTIES LINK_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/ffprocams.map)
if(FFPROCAMS_SANITIZE)
  target_link_options(ffprocams_shared PRIVATE ${FFP_SANITIZERS})
  foreach(kind shared static) # clang puts the sanitizers' code into the program
    target_link_options(ffprocams_${kind} INTERFACE "$<BUILD_INTERFACE:${FFP_SANITIZERS}>")
  endforeach()
else()
  target_link_options(ffprocams_shared PRIVATE LINKER:--no-undefined)
endif()

# The target that an outer project links; the name is that of the installed package.
if(DEFINED BUILD_SHARED_LIBS AND NOT BUILD_SHARED_LIBS)
  add_library(ffprocams::ffprocams ALIAS ffprocams_static)
else()
  add_library(ffprocams::ffprocams ALIAS ffprocams_shared)
endif()

# From the library to the data, as they will be installed (src/engine/network/shipped.c).
file(RELATIVE_PATH to_data ${CMAKE_INSTALL_FULL_LIBDIR} ${CMAKE_INSTALL_FULL_DATADIR})
set_source_files_properties(src/engine/network/shipped.c PROPERTIES COMPILE_DEFINITIONS FFP_LIBRARY_TO_DATA="${to_data}")
# And from programs to modules (src/core/base/module.c).
set(module_folder ${CMAKE_INSTALL_LIBDIR}/ffprocams)
file(RELATIVE_PATH to_modules ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR}/ffprocams)
set_source_files_properties(src/core/base/module.c PROPERTIES COMPILE_DEFINITIONS FFP_PROGRAM_TO_MODULES="${to_modules}")
# In a build folder the weights lie beside the library, as seen from it (src/engine/network/shipped.c).
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/models ${PROJECT_BINARY_DIR}/models SYMBOLIC)

file(GLOB cli_sources CONFIGURE_DEPENDS src/product/cli/*.c)
add_executable(ffprocams ${cli_sources})
target_link_libraries(ffprocams PRIVATE ffp_compile ffprocams_shared PkgConfig::JANSSON m)
target_include_directories(ffprocams PRIVATE src)

ffp_option(STUDIO "libmicrohttpd, for `ffprocams studio`")
if(NOT FFPROCAMS_STUDIO STREQUAL "OFF")
  pkg_check_modules(MICROHTTPD QUIET IMPORTED_TARGET libmicrohttpd>=0.9.75)
endif()
if(TARGET PkgConfig::MICROHTTPD)
  file(GLOB studio_sources CONFIGURE_DEPENDS src/product/studio/*.c src/product/server/*.c)
  target_sources(ffprocams PRIVATE ${studio_sources} ${studio_pages})
  target_compile_definitions(ffprocams PRIVATE FFP_WITH_STUDIO)
  target_link_libraries(ffprocams PRIVATE PkgConfig::MICROHTTPD)
else()
  ffp_without(STUDIO "`studio`" libmicrohttpd-dev)
endif()

if(FFPROCAMS_MPI)
  find_package(MPI 3.0 REQUIRED COMPONENTS C)
  target_sources(ffprocams PRIVATE src/product/cluster/mpi.c)
  target_compile_definitions(ffprocams PRIVATE FFP_WITH_MPI)
  target_link_libraries(ffprocams PRIVATE MPI::MPI_C)
endif()

# pages/*.1 and pages/ffprocams-completion.bash: the program writes them itself, from its tables of options.
if(NOT CMAKE_CROSSCOMPILING)
  add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/pages/ffprocams.1
                     COMMAND ffprocams --pages ${PROJECT_BINARY_DIR}/pages DEPENDS ffprocams)
  set(all "")
  if(top_level OR FFPROCAMS_INSTALL)
    set(all ALL)
  endif()
  add_custom_target(ffprocams_pages ${all} DEPENDS ${PROJECT_BINARY_DIR}/pages/ffprocams.1)
endif()
