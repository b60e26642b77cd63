# The libraries of others.
find_package(PkgConfig REQUIRED)
find_package(OpenMP REQUIRED C)
# What the library stands on, as NAME:MODULE of pkg-config. Whoever links libffprocams.a needs them too
# (cmake/install.cmake). What modules stand on is modules.cmake's affair; libtiff alone is always needed.
set(FFP_PACKAGES PNG:libpng ZLIB:zlib JPEG:libjpeg OPENEXR:OpenEXR JANSSON:jansson YAML:yaml-0.1 EXPAT:expat ZSTD:libzstd LCMS:lcms2
                 OPENBLAS:openblas)
foreach(entry ${FFP_PACKAGES})
  string(REPLACE ":" ";" entry ${entry})
  list(GET entry 0 name)
  list(GET entry 1 module)
  pkg_check_modules(${name} REQUIRED IMPORTED_TARGET ${module})
endforeach()
pkg_check_modules(TIFF REQUIRED IMPORTED_TARGET libtiff-4)
if(TIFF_VERSION VERSION_LESS 4.5)
  message(FATAL_ERROR "libtiff ${TIFF_VERSION} has no error handlers of its files' own: 4.5 is needed")
endif()
if(FFPROCAMS_TESTS)
  pkg_check_modules(CMOCKA IMPORTED_TARGET cmocka)
endif()
