# Tests that run threads side by side: ctest -L threads. Under ThreadSanitizer (FFPROCAMS_SANITIZE=thread) the target thread_tests
# builds them alone, and LLVM's archer tells it what OpenMP's barriers order.
set(FFP_THREAD_TESTS test_queue test_stream test_training test_render test_pass test_start test_denoise test_refine test_pyramid
                     test_thin test_capture test_generate test_products test_scan test_attention test_contexts test_call)
if(FFPROCAMS_SANITIZE STREQUAL "thread")
  execute_process(COMMAND ${CMAKE_C_COMPILER} -print-resource-dir OUTPUT_VARIABLE clang OUTPUT_STRIP_TRAILING_WHITESPACE)
  find_library(FFP_ARCHER archer PATHS ${clang}/../.. REQUIRED)
endif()

add_custom_target(thread_tests)
foreach(test ${FFP_THREAD_TESTS})
  if(TARGET ${test})
    add_dependencies(thread_tests ${test})
    set_property(TEST ${test} APPEND PROPERTY LABELS threads)
    if(FFP_ARCHER)
      set_property(TEST ${test} APPEND PROPERTY ENVIRONMENT "OMP_TOOL_LIBRARIES=${FFP_ARCHER}"
                   "TSAN_OPTIONS=ignore_noninstrumented_modules=1") # OpenBLAS, Embree
    endif()
  endif()
endforeach()
