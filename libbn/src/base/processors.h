/* SPDX-License-Identifier: Apache-2.0
 * The number of CPUs. bn.h declares bn_thread_count(). */
#ifndef BN_PROCESSORS_H
#define BN_PROCESSORS_H

#include <bn/bn.h>

/* Linux: the CPUs whose time the process's control groups grant, or UINT32_MAX without a limit. `root` is the
 * folder that contains /proc and /sys; tests pass their own. */
uint32_t bn_processors_granted(const char *root);

#endif
