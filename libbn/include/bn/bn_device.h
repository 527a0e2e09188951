/* SPDX-License-Identifier: Apache-2.0
 * Portability macros for the code that C, GPUs and shaders share: bn_draw.glsl, bn_path.glsl and
 * bn_choose.glsl, which bn_draw.h, bn_path.h and bn_choose.h include. Each of those headers
 * includes this one twice: before the shared code to define the macros, and after it to undefine
 * them. In CUDA and HIP the functions are `__host__ __device__`. NVRTC and hipRTC compile for the
 * GPU only and have no system headers, so bn.h is left out. */
#ifndef BN_BN_DEVICE_H

#if defined(__CUDACC_RTC__) || defined(__HIPCC_RTC__)
#define BN_DEVICE_ONLY 1
typedef signed int int32_t;
typedef unsigned int uint32_t;
#endif

#if defined(__CUDACC__) || defined(__HIPCC__) || defined(BN_DEVICE_ONLY)
/* Defined if the functions are compiled for a GPU as well. */
#define BN_DEVICE_TOO 1
#endif

#ifndef BN_DEVICE_ONLY
#include <bn/bn.h>
#endif

#endif

#ifndef BN_UINT

/* External linkage in C++, so that a program's inline functions may call them. */
#ifdef __cplusplus
#define BN_HOST_INLINE inline
#define BN_CAST(type, v) static_cast<type>(v)
#else
#define BN_HOST_INLINE static inline
#define BN_CAST(type, v) (type)(v)
#endif
#ifdef BN_DEVICE_TOO
#define BN_DEVICE_INLINE inline __host__ __device__
#define bn_draw_domain_child bn_domain_child
#else
#define BN_DEVICE_INLINE BN_HOST_INLINE
#endif

#define BN_UINT uint32_t
#define BN_BOOL int
#define BN_FALSE 0
#define BN_FUNCTION BN_DEVICE_INLINE

/* The leading parameter and argument of every draw function, each including its trailing comma. Both are
 * empty in shaders, which read the table only through BN_WORD. */
#define BN_TABLE const uint32_t *bn_words,
#define BN_PASS_TABLE bn_words,
#define BN_WORD(i) bn_words[i]

/* Converts via signed integers because CPUs have instructions for them. */
#define BN_TO_UINT(v) BN_CAST(uint32_t, BN_CAST(int32_t, v))
#define BN_TO_FLOAT(v) BN_CAST(float, BN_CAST(int32_t, v))
#define BN_MULTIPLY_HIGH(a, b) BN_CAST(uint32_t, BN_CAST(unsigned long long, a) * (b) >> 32)
#if defined(__CUDA_ARCH__) || defined(__HIP_DEVICE_COMPILE__)
#define BN_REVERSE_BITS(v) __brev(v)
#endif

#ifndef BN_BN_DEVICE_H
#define BN_BN_DEVICE_H
BN_DEVICE_INLINE uint32_t bn_float_bits(float v) {
    union {
        float number;
        uint32_t bits;
    } u;
    u.number = v;
    return u.bits;
}
#endif

#else

#undef BN_HOST_INLINE
#undef BN_CAST
#undef BN_DEVICE_INLINE
#undef bn_draw_domain_child
#undef BN_UINT
#undef BN_BOOL
#undef BN_FALSE
#undef BN_FUNCTION
#undef BN_TABLE
#undef BN_PASS_TABLE
#undef BN_WORD
#undef BN_TO_UINT
#undef BN_TO_FLOAT
#undef BN_MULTIPLY_HIGH
#undef BN_REVERSE_BITS
/* Defined by the shared code. */
#undef BN_ANY
#undef BN_ROW
#undef BN_HALF_ROW
#undef BN_KEY_FACTOR
#undef BN_CHOOSE_STEPS

#endif
