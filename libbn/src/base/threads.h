/* SPDX-License-Identifier: Apache-2.0
 * A team of threads that runs one function together, in steps. The one file that knows threads. */
#ifndef BN_THREADS_H
#define BN_THREADS_H

#include <stdint.h>

typedef struct bn_team bn_team;

/* Work of member `index` of `size`; member 0 is the calling thread. */
typedef void (*bn_team_work)(void *user, bn_team *team, uint32_t index, uint32_t size);

/* The number of processors, at least 1. */
uint32_t bn_thread_count(void);

/* Runs work on `threads` threads, or on as many as can be had, and waits for all. Systems without
 * POSIX threads use the calling thread alone. */
void bn_team_run(uint32_t threads, bn_team_work work, void *user);

/* Waits until all members have come here. What they wrote before is seen by all after. */
void bn_team_wait(bn_team *team);

/* 0, 1, 2 ... in the order in which members ask, across all of them. */
uint32_t bn_team_next(bn_team *team);

/* From now on bn_team_next() gives UINT32_MAX. */
void bn_team_stop(bn_team *team);

#endif
