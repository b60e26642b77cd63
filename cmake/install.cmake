# cmake --install: the program and what it needs to run (component runtime), and what it takes to build against the
# library (component development). Nothing installed names the prefix, so that it can be moved.
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/ffprocams)
set(data_folder ${CMAKE_INSTALL_DATADIR}/ffprocams)

file(RELATIVE_PATH to_library ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
set_target_properties(ffprocams PROPERTIES INSTALL_RPATH "$ORIGIN/${to_library}")

install(TARGETS ffprocams RUNTIME COMPONENT runtime)
install(TARGETS ffprocams_shared EXPORT ffprocams-shared
        LIBRARY COMPONENT runtime NAMELINK_COMPONENT development INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS ffprocams_static EXPORT ffprocams-static
        ARCHIVE COMPONENT development INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS ${modules} LIBRARY DESTINATION ${module_folder} COMPONENT runtime)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/ ${PROJECT_BINARY_DIR}/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN "*.h")
install(FILES models/small.safetensors models/README.md DESTINATION ${data_folder}/models COMPONENT runtime)
install(DIRECTORY data/sample data/sculpture DESTINATION ${data_folder} COMPONENT runtime)
install(FILES data/sun.png DESTINATION ${data_folder} COMPONENT runtime)
if(TARGET ffprocams_pages)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/pages/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT runtime
          FILES_MATCHING PATTERN "*.1")
  install(FILES ${PROJECT_BINARY_DIR}/pages/ffprocams-completion.bash RENAME ffprocams
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT runtime)
endif()
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)

# Libraries for linking the archive: modules of pkg-config and plain libraries.
set(FFP_REQUIRES "")
set(FFP_FIND "")
foreach(entry ${FFP_PACKAGES})
  string(REPLACE ":" ";" entry ${entry})
  list(GET entry 0 name)
  list(GET entry 1 module)
  string(APPEND FFP_REQUIRES " ${module}")
  string(APPEND FFP_FIND "  pkg_check_modules(${name} \${quiet} IMPORTED_TARGET ${module})\n"
                         "  if(NOT ${name}_FOUND)\n    list(APPEND missing ${module})\n  endif()\n")
endforeach()
set(FFP_LIBS "")
foreach(library ${FFP_SYSTEM_LIBRARIES})
  string(APPEND FFP_LIBS " -l${library}")
endforeach()
if(FFPROCAMS_CUDA)
  string(APPEND FFP_LIBS " -L${CUDAToolkit_LIBRARY_DIR} -lcublas -lcudart")
  string(APPEND FFP_FIND "  find_dependency(CUDAToolkit)\n")
endif()

# From the file's own place: the folders of libraries and of headers may be absolute ones, outside the prefix.
set(pc_folder ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pc_to_prefix ${pc_folder} ${CMAKE_INSTALL_PREFIX})
file(RELATIVE_PATH pc_to_headers ${pc_folder} ${CMAKE_INSTALL_FULL_INCLUDEDIR})
string(REGEX REPLACE "/$" "" pc_to_prefix "${pc_to_prefix}")
function(write_pc pc_name pc_kind pc_libs pc_requires)
  configure_file(cmake/ffprocams.pc.in ${pc_name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${pc_name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endfunction()
write_pc(ffprocams "" "-lffprocams" "") # asks for nothing else: pkg-config wants the .pc files of Requires.private even for --cflags
write_pc(ffprocams-static " (static)" "-l:libffprocams.a${FFP_LIBS}" "\nRequires:${FFP_REQUIRES}")

configure_package_config_file(cmake/ffprocams-config.cmake.in ffprocams-config.cmake
                              INSTALL_DESTINATION ${package_folder} NO_SET_AND_CHECK_MACRO)
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(ffprocams-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/ffprocams-config.cmake ${PROJECT_BINARY_DIR}/ffprocams-config-version.cmake
        DESTINATION ${package_folder} COMPONENT development)
foreach(kind shared static)
  install(EXPORT ffprocams-${kind} NAMESPACE ffprocams:: DESTINATION ${package_folder} COMPONENT development)
endforeach()
