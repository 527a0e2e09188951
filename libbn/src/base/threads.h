/* SPDX-License-Identifier: Apache-2.0
 * A team of threads that runs one function in steps. Only threads.c uses system threads. */
#ifndef BN_THREADS_H
#define BN_THREADS_H

#include <stdint.h>

typedef struct bn_team bn_team;

enum { BN_TEAM_MOST = 64 }; /* members */

/* The number of threads for an option `threads`: its value, or the number of CPUs if 0; at most BN_TEAM_MOST. */
uint32_t bn_team_threads(uint32_t option);

/* The work for member `index` of `size`. Member 0 is the calling thread. */
typedef void (*bn_team_work)(void *user, bn_team *team, uint32_t index, uint32_t size);

/* Runs `work` on `threads` threads, or on as many as the system and BN_TEAM_MOST allow, and waits for all of them. */
void bn_team_run(uint32_t threads, bn_team_work work, void *user);

/* A barrier: waits until all members have called it. Everything written before it is visible to all
 * members afterwards. */
void bn_team_wait(bn_team *team);

/* A counter that all members share: 0, 1, 2 ... */
uint32_t bn_team_next(bn_team *team);

/* Makes every later bn_team_next() return UINT32_MAX. */
void bn_team_stop(bn_team *team);

#endif
