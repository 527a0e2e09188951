# SPDX-License-Identifier: Apache-2.0
# The instruction sets for which src/simd is compiled, in addition to plain C. Each file has its own flags.
# The library selects one at run time, so it does not matter which of them the build machine supports.
set(bn_simd_definition "")
if(CMAKE_C_COMPILER_ID MATCHES "GNU|Clang")
    string(TOLOWER "${CMAKE_SYSTEM_PROCESSOR}" bn_processor)
    if(APPLE AND CMAKE_OSX_ARCHITECTURES)
        # The target may differ from the build machine. Two architectures at once match neither case below
        # and get plain C.
        string(TOLOWER "${CMAKE_OSX_ARCHITECTURES}" bn_processor)
    endif()
    if(bn_processor MATCHES "^(x86_64|amd64)$" AND CMAKE_SIZEOF_VOID_P EQUAL 8)
        set(bn_simd_definition BN_SIMD_X86)
        list(APPEND bn_sources src/simd/avx2.c)
        set_source_files_properties(src/simd/avx2.c PROPERTIES COMPILE_OPTIONS "-mavx2")
    elseif(bn_processor MATCHES "^(aarch64|arm64)$")
        set(bn_simd_definition BN_SIMD_ARM)
        list(APPEND bn_sources src/simd/neon.c)
    endif()
endif()
