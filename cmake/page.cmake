# The page of src/product/view: page.html with styles, shaders and scripts in it, as an array.
file(GLOB page_sources CONFIGURE_DEPENDS view/*)
set(page_array ${PROJECT_BINARY_DIR}/page_template.c)
add_custom_command(OUTPUT ${page_array}
                   COMMAND ${CMAKE_COMMAND} -DFROM=${PROJECT_SOURCE_DIR}/view -DTO=${page_array} -P ${PROJECT_SOURCE_DIR}/cmake/write_page.cmake
                   DEPENDS ${page_sources} cmake/write_page.cmake)
target_sources(ffp_view PRIVATE ${page_array})

