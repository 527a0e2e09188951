/* SPDX-License-Identifier: Apache-2.0
 * Teams of POSIX threads, with a barrier made of a mutex and a condition (the POSIX barrier is
 * optional). */
#define _POSIX_C_SOURCE 200809L
#define _DARWIN_C_SOURCE 1 /* the number of processors, on macOS */
#include "base/threads.h"

#if defined(_WIN32)

struct bn_team {
    uint32_t next;
    int stopped;
};

uint32_t bn_thread_count(void) {
    return 1;
}

void bn_team_run(uint32_t threads, bn_team_work work, void *user) {
    bn_team team = {0, 0};
    (void)threads;
    work(user, &team, 0, 1);
}

void bn_team_wait(bn_team *team) {
    (void)team;
}

uint32_t bn_team_next(bn_team *team) {
    return team->stopped ? UINT32_MAX : team->next++;
}

void bn_team_stop(bn_team *team) {
    team->stopped = 1;
}

#else

#include <pthread.h>
#include <unistd.h>

enum { BN_THREADS_MOST = 64 };

struct bn_team {
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    uint32_t size; /* 0 until all threads have been started */
    uint32_t waiting, generation, next;
    int stopped;
    bn_team_work work;
    void *user;
};

typedef struct team_member {
    bn_team *team;
    uint32_t index;
    pthread_t thread;
} team_member;

uint32_t bn_thread_count(void) {
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count < 1 ? 1 : count > BN_THREADS_MOST ? BN_THREADS_MOST : (uint32_t)count;
}

void bn_team_wait(bn_team *team) {
    pthread_mutex_lock(&team->mutex);
    const uint32_t generation = team->generation;
    if (++team->waiting == team->size) {
        team->waiting = 0;
        ++team->generation;
        pthread_cond_broadcast(&team->changed);
    } else {
        while (generation == team->generation) pthread_cond_wait(&team->changed, &team->mutex);
    }
    pthread_mutex_unlock(&team->mutex);
}

uint32_t bn_team_next(bn_team *team) {
    pthread_mutex_lock(&team->mutex);
    const uint32_t next = team->stopped ? UINT32_MAX : team->next++;
    pthread_mutex_unlock(&team->mutex);
    return next;
}

void bn_team_stop(bn_team *team) {
    pthread_mutex_lock(&team->mutex);
    team->stopped = 1;
    pthread_mutex_unlock(&team->mutex);
}

static void *run(void *user) {
    team_member *m = user;
    bn_team *team = m->team;
    pthread_mutex_lock(&team->mutex);
    while (team->size == 0) pthread_cond_wait(&team->changed, &team->mutex);
    const uint32_t size = team->size;
    pthread_mutex_unlock(&team->mutex);
    team->work(team->user, team, m->index, size);
    return NULL;
}

void bn_team_run(uint32_t threads, bn_team_work work, void *user) {
    team_member members[BN_THREADS_MOST];
    bn_team team = {.work = work, .user = user};
    uint32_t size = 1;
    if (pthread_mutex_init(&team.mutex, NULL) != 0 || pthread_cond_init(&team.changed, NULL) != 0) {
        threads = 1;
    }
    for (; size < threads && size < BN_THREADS_MOST; ++size) {
        members[size].team = &team;
        members[size].index = size;
        if (pthread_create(&members[size].thread, NULL, run, &members[size]) != 0) break;
    }
    pthread_mutex_lock(&team.mutex);
    team.size = size;
    pthread_cond_broadcast(&team.changed);
    pthread_mutex_unlock(&team.mutex);
    work(user, &team, 0, size);
    for (uint32_t i = 1; i < size; ++i) pthread_join(members[i].thread, NULL);
    pthread_cond_destroy(&team.changed);
    pthread_mutex_destroy(&team.mutex);
}

#endif
