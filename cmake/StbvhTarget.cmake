# What sources of one instruction set are compiled with.
set(STBVH_AVX2 -mavx2 -mfma)
set(STBVH_AVX512 ${STBVH_AVX2} -mavx512f -mavx512vl -mavx512dq -mavx512bw)

# stbvh_target(NAME): the settings that every target of the project shares.
#
# -ffp-contract=off because the watertight test needs the edge functions without fma (docs/algorithm.md);
# where an fma is wanted it is written out.
function(stbvh_target name)
  target_compile_features(${name} PUBLIC cxx_std_20)
  set_target_properties(${name} PROPERTIES
    CXX_EXTENSIONS OFF C_STANDARD 99 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF
    CXX_VISIBILITY_PRESET hidden C_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${name} PRIVATE -ffp-contract=off -fno-math-errno
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion $<$<BOOL:${STBVH_WERROR}>:-Werror>)
  if(STBVH_SANITIZE)
    # gcc loses track of what is initialised in what it instruments: std::regex alone gets five such warnings.
    target_compile_options(${name} PRIVATE -fsanitize=${STBVH_SANITIZE} -fno-omit-frame-pointer
      -fno-sanitize-recover=all $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    target_link_options(${name} PUBLIC -fsanitize=${STBVH_SANITIZE})
  endif()
  get_target_property(type ${name} TYPE)
  if(type STREQUAL "EXECUTABLE" AND STBVH_SANITIZE STREQUAL "thread")
    target_link_libraries(${name} PRIVATE stbvh_tsan)
  endif()
endfunction()
