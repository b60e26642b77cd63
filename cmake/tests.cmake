# Tests of what the library looks like from outside: its headers, its examples, and what is installed.
add_test(NAME headers COMMAND ${PROJECT_SOURCE_DIR}/script/test-headers ${CMAKE_C_COMPILER} ${CMAKE_CXX_COMPILER})

add_subdirectory(examples)
add_test(NAME example_reconstruct
         COMMAND example_reconstruct ${PROJECT_SOURCE_DIR}/data/sample ${PROJECT_BINARY_DIR}/example.ply)
add_test(NAME example_relight
         COMMAND example_relight ${PROJECT_BINARY_DIR}/example.ply ${PROJECT_SOURCE_DIR}/data/sample ${PROJECT_BINARY_DIR}/example.ppm)
add_test(NAME example_progress COMMAND example_progress ${PROJECT_SOURCE_DIR}/data/sample 100)
add_test(NAME example_cancel COMMAND example_progress ${PROJECT_SOURCE_DIR}/data/sample 0.2)
set_tests_properties(example_relight PROPERTIES DEPENDS example_reconstruct)
set_tests_properties(example_progress PROPERTIES PASS_REGULAR_EXPRESSION "done: [0-9]+ Gaussians")
set_tests_properties(example_cancel PROPERTIES PASS_REGULAR_EXPRESSION "stopped after")

# README.md's examples, in a minute; sanitized they take too long.
if(NOT FFPROCAMS_SANITIZE)
  add_test(NAME readme COMMAND ${PROJECT_SOURCE_DIR}/tests/cli/readme.sh $<TARGET_FILE:ffprocams> $<TARGET_FILE:ffprocams_shared>)
endif()

# A sanitized library asks all that link it for the sanitizers.
if(FFPROCAMS_INSTALL AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME install COMMAND ${PROJECT_SOURCE_DIR}/script/test-install ${PROJECT_BINARY_DIR})
endif()
