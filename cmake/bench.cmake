# Programs that measure (bench/), each built when it is asked for, none installed.

# Milliseconds of the GPU's work.
if(TARGET ffp_cuda)
  add_executable(gpu_times EXCLUDE_FROM_ALL bench/gpu_times.c)
  target_include_directories(gpu_times PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(gpu_times PRIVATE ffp_cuda ffp_pipeline ffp_train)
endif()

# Pictures and figures of the training world, for docs/.
if(TARGET ffp_synth)
  add_executable(contact_sheets EXCLUDE_FROM_ALL bench/contact_sheets.c)
  target_link_libraries(contact_sheets PRIVATE ffp_synth)
endif()

# The limits of a reconstruction, found by putting the truth in.
if(TARGET ffp_train)
  add_executable(limits EXCLUDE_FROM_ALL bench/limits.c)
  target_link_libraries(limits PRIVATE ffp_train)
endif()

# The encoder alone, for comparison with other libraries' form of it (bench/peers).
if(TARGET ffp_network)
  add_executable(encoder_times EXCLUDE_FROM_ALL bench/encoder_times.c)
  target_link_libraries(encoder_times PRIVATE ffp_network)
endif()

# The rasteriser alone, for the same. And the instructions of all kernels (script/test-arm --count).
if(TARGET ffp_bench)
  add_executable(splat_times EXCLUDE_FROM_ALL bench/splat_times.c)
  target_link_libraries(splat_times PRIVATE ffp_bench)
  add_executable(kernel_counts EXCLUDE_FROM_ALL bench/kernel_counts.c)
  target_link_libraries(kernel_counts PRIVATE ffp_bench)
endif()

# The gain of a compensated projection on captures with true depth.
if(TARGET ffp_apply)
  add_executable(compensate_report EXCLUDE_FROM_ALL bench/compensate_report.c)
  target_link_libraries(compensate_report PRIVATE ffp_api ffp_apply)
endif()

# Faults of rigs and captures: what the checks before the work say of them.
if(TARGET ffp_api AND TARGET ffp_synth)
  add_executable(rig_faults EXCLUDE_FROM_ALL bench/rig_faults.c)
  target_link_libraries(rig_faults PRIVATE ffp_api ffp_checks ffp_synth)
endif()

# Calibrations without a board of random walks with known faults: errors against what is stated of them.
if(TARGET ffp_selfcal)
  add_executable(walk_faults EXCLUDE_FROM_ALL bench/walk_faults.c)
  target_include_directories(walk_faults PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(walk_faults PRIVATE ffp_selfcal)
endif()
