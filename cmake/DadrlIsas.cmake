# The instruction sets beside the portable one that kernels are compiled for (common/util/isa.h chooses at run time), and
# their flags: DADRL_ISAS, DADRL_FLAGS_<isa>. None on other processors than x86-64.
set(DADRL_ISAS)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  set(DADRL_ISAS avx2 avx512)
  set(DADRL_FLAGS_avx2 -mavx2 -mfma)
  # Without the last one clang splits 64-byte vectors in two.
  set(DADRL_FLAGS_avx512 -mavx512f -mavx512bw -mavx512dq -mavx512vl -mfma -mprefer-vector-width=512)
endif()
