/* SPDX-License-Identifier: Apache-2.0
 * What the inline functions of bn_draw.h and bn_choose.h need to be compiled for a GPU too; those
 * headers include this one. With CUDA and HIP the functions are `__host__ __device__`. NVRTC and
 * hipRTC compile for the GPU alone and have no system headers: there bn.h is left out. */
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

#endif
