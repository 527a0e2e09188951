/* SPDX-License-Identifier: Apache-2.0
 * What the text that C, GPUs and shaders share is written in: bn_draw.glsl, bn_path.glsl and
 * bn_choose.glsl, which bn_draw.h, bn_path.h and bn_choose.h compile. With CUDA and HIP the functions
 * are `__host__ __device__`. NVRTC and hipRTC compile for the GPU alone and have no system headers:
 * there bn.h is left out. */
#ifndef BN_BN_DEVICE_H
#define BN_BN_DEVICE_H

#if defined(__CUDACC_RTC__) || defined(__HIPCC_RTC__)
#define BN_DEVICE_ONLY 1
typedef signed int int32_t;
typedef unsigned int uint32_t;
#else
#include <bn/bn.h>
#endif

#if defined(__CUDACC__) || defined(__HIPCC__) || defined(BN_DEVICE_ONLY)
/* Defined where the functions are compiled for a GPU too. */
#define BN_DEVICE_TOO 1
/* What the functions begin with. */
#define BN_DEVICE_INLINE static inline __host__ __device__
#else
#define BN_DEVICE_INLINE static inline
#endif

#define BN_UINT uint32_t
#define BN_BOOL int
#define BN_FALSE 0
#define BN_FUNCTION BN_DEVICE_INLINE

/* The first parameter and argument of every draw, each with its comma: in shaders, which reach the
 * table through BN_WORD alone, both are empty. */
#define BN_TABLE const uint32_t *bn_words,
#define BN_PASS_TABLE bn_words,
#define BN_WORD(i) bn_words[i]

#ifdef __cplusplus
#define BN_CAST(type, v) static_cast<type>(v)
#else
#define BN_CAST(type, v) (type)(v)
#endif
/* By signed numbers, for which processors have instructions. */
#define BN_TO_UINT(v) BN_CAST(uint32_t, BN_CAST(int32_t, v))
#define BN_TO_FLOAT(v) BN_CAST(float, BN_CAST(int32_t, v))
#define BN_MULTIPLY_HIGH(a, b) BN_CAST(uint32_t, BN_CAST(unsigned long long, a) * (b) >> 32)
#if defined(__CUDA_ARCH__) || defined(__HIP_DEVICE_COMPILE__)
#define BN_REVERSE_BITS(v) __brev(v)
#endif

#endif
