/* SPDX-License-Identifier: Apache-2.0
 * Thread teams. The barrier uses a lock and a condition variable: POSIX barriers are optional, and
 * Windows has none before version 8. Locks, condition variables and threads are the system's. */
#define _POSIX_C_SOURCE 200809L
#define _DARWIN_C_SOURCE 1 /* for the number of CPUs on macOS */
#include "base/threads.h"

enum { BN_THREADS_MOST = 64 };

typedef struct team_member {
    bn_team *team;
    uint32_t index;
} team_member;

static void member_run(team_member *member);

/* ---- System threads */

#if defined(_WIN32)

#define WIN32_LEAN_AND_MEAN
#ifndef _WIN32_WINNT
#define _WIN32_WINNT 0x0601 /* Windows 7: slim locks and conditions */
#endif
#include <windows.h>

typedef SRWLOCK lock;
typedef CONDITION_VARIABLE condition;
typedef HANDLE thread;
#define LOCK_INITIALIZER SRWLOCK_INIT
#define CONDITION_INITIALIZER CONDITION_VARIABLE_INIT
#define lock_destroy(l) (void)(l) /* has nothing to release */
#define condition_destroy(c) (void)(c)
#define lock_take AcquireSRWLockExclusive
#define lock_leave ReleaseSRWLockExclusive
#define condition_wait(c, l) SleepConditionVariableSRW(c, l, INFINITE, 0)
#define condition_wake_all WakeAllConditionVariable

static DWORD WINAPI run(void *member) {
    member_run(member);
    return 0;
}

static int thread_start(thread *t, team_member *member) {
    *t = CreateThread(NULL, 0, run, member, 0, NULL);
    return *t != NULL;
}

static void thread_join(thread t) {
    WaitForSingleObject(t, INFINITE);
    CloseHandle(t);
}

static long processor_count(void) {
    SYSTEM_INFO info;
    GetSystemInfo(&info);
    return (long)info.dwNumberOfProcessors;
}

#else

#include <pthread.h>
#include <unistd.h>

typedef pthread_mutex_t lock;
typedef pthread_cond_t condition;
typedef pthread_t thread;
#define LOCK_INITIALIZER PTHREAD_MUTEX_INITIALIZER
#define CONDITION_INITIALIZER PTHREAD_COND_INITIALIZER
#define lock_destroy pthread_mutex_destroy
#define condition_destroy pthread_cond_destroy
#define lock_take pthread_mutex_lock
#define lock_leave pthread_mutex_unlock
#define condition_wait pthread_cond_wait
#define condition_wake_all pthread_cond_broadcast

static void *run(void *member) {
    member_run(member);
    return NULL;
}

static int thread_start(thread *t, team_member *member) {
    return pthread_create(t, NULL, run, member) == 0;
}

static void thread_join(thread t) {
    pthread_join(t, NULL);
}

static long processor_count(void) {
    return sysconf(_SC_NPROCESSORS_ONLN);
}

#endif

/* ---- Teams */

struct bn_team {
    lock own;
    condition changed;
    uint32_t size; /* 0 until all threads have been started */
    uint32_t waiting, generation, next;
    int stopped;
    bn_team_work work;
    void *user;
};

uint32_t bn_thread_count(void) {
    long count = processor_count();
    return count < 1 ? 1 : count > BN_THREADS_MOST ? BN_THREADS_MOST : (uint32_t)count;
}

void bn_team_wait(bn_team *team) {
    lock_take(&team->own);
    const uint32_t generation = team->generation;
    if (++team->waiting == team->size) {
        team->waiting = 0;
        ++team->generation;
        condition_wake_all(&team->changed);
    } else {
        while (generation == team->generation) condition_wait(&team->changed, &team->own);
    }
    lock_leave(&team->own);
}

uint32_t bn_team_next(bn_team *team) {
    lock_take(&team->own);
    const uint32_t next = team->stopped ? UINT32_MAX : team->next++;
    lock_leave(&team->own);
    return next;
}

void bn_team_stop(bn_team *team) {
    lock_take(&team->own);
    team->stopped = 1;
    lock_leave(&team->own);
}

static void member_run(team_member *member) {
    bn_team *team = member->team;
    lock_take(&team->own);
    while (team->size == 0) condition_wait(&team->changed, &team->own);
    const uint32_t size = team->size;
    lock_leave(&team->own);
    team->work(team->user, team, member->index, size);
}

void bn_team_run(uint32_t threads, bn_team_work work, void *user) {
    team_member members[BN_THREADS_MOST];
    thread started[BN_THREADS_MOST];
    bn_team team = {LOCK_INITIALIZER, CONDITION_INITIALIZER, .work = work, .user = user};
    uint32_t size = 1;
    for (; size < threads && size < BN_THREADS_MOST; ++size) {
        members[size].team = &team;
        members[size].index = size;
        if (!thread_start(&started[size], &members[size])) break;
    }
    lock_take(&team.own);
    team.size = size;
    condition_wake_all(&team.changed);
    lock_leave(&team.own);
    work(user, &team, 0, size);
    for (uint32_t i = 1; i < size; ++i) thread_join(started[i]);
    condition_destroy(&team.changed);
    lock_destroy(&team.own);
}
