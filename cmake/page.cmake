# Pages: view/PAGE.html with styles, shaders and scripts in it, as an array of C, ended by a 0, and its size without that.
file(GLOB page_sources CONFIGURE_DEPENDS view/*)
function(ffp_page page array out) # [NAME.js=OTHER.js]: another script in its place
  add_custom_command(OUTPUT ${out}
                     COMMAND ${CMAKE_COMMAND} -DFROM=${PROJECT_SOURCE_DIR}/view -DPAGE=${page} -DARRAY=${array} -DTO=${out} -DINSTEAD=${ARGN}
                             -P ${PROJECT_SOURCE_DIR}/cmake/write_page.cmake
                     DEPENDS ${page_sources} cmake/write_page.cmake)
endfunction()

# Of `ffprocams view`, and those of `ffprocams studio`.
set(page_array ${PROJECT_BINARY_DIR}/page_template.c)
ffp_page(page ffp_page_template ${page_array})
target_sources(ffp_view PRIVATE ${page_array})
set(studio_pages ${PROJECT_BINARY_DIR}/page_studio.c ${PROJECT_BINARY_DIR}/page_projector.c)
ffp_page(studio ffp_page_studio ${PROJECT_BINARY_DIR}/page_studio.c)
ffp_page(studio_projector ffp_page_projector ${PROJECT_BINARY_DIR}/page_projector.c)
