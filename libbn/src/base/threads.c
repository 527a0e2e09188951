/* SPDX-License-Identifier: Apache-2.0
 * Thread teams. The barrier uses a lock and a condition variable: POSIX barriers are optional, and
 * Windows has none before version 8. Locks, condition variables and threads are the system's.
 *
 * If the system cannot start all threads, the team is smaller. Threads therefore wait until `size` is known, so
 * that none waits at a barrier for a member that was not started. A team lives for one call, because computations
 * take milliseconds to minutes, and starting a thread tens of microseconds. */
#define _POSIX_C_SOURCE 200809L
#include "base/threads.h"
#include "base/assert.h"
#include <bn/bn.h>

typedef struct team_member {
    bn_team *team;
    uint32_t index;
} team_member;

static void member_run(team_member *member);

/* ---- System threads */

#if defined(_WIN32)

#include "base/windows.h"

/* Slim locks and conditions: structures of one pointer, without a destructor. */
typedef struct lock {
    void *state;
} lock;
typedef struct condition {
    void *state;
} condition;
typedef void *thread;
#define LOCK_INITIALIZER                                                                           \
    { NULL }
#define CONDITION_INITIALIZER                                                                      \
    { NULL }
#define NO_TIME_LIMIT 0xffffffffu
#define lock_destroy(l) (void)(l)
#define condition_destroy(c) (void)(c)
#define lock_take(l) AcquireSRWLockExclusive((struct _RTL_SRWLOCK *)(l))
#define lock_leave(l) ReleaseSRWLockExclusive((struct _RTL_SRWLOCK *)(l))
#define condition_wait(c, l)                                                                       \
    SleepConditionVariableSRW((struct _RTL_CONDITION_VARIABLE *)(c), (struct _RTL_SRWLOCK *)(l),   \
                              NO_TIME_LIMIT, 0)
#define condition_wake_all(c) WakeAllConditionVariable((struct _RTL_CONDITION_VARIABLE *)(c))

static unsigned long __stdcall run(void *member) {
    member_run(member);
    return 0;
}

static int thread_start(thread *t, team_member *member) {
    *t = CreateThread(NULL, 0, run, member, 0, NULL);
    return *t != NULL;
}

static void thread_join(thread t) {
    WaitForSingleObject(t, NO_TIME_LIMIT);
    CloseHandle(t);
}

#else

#include <pthread.h>

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

#endif

/* ---- Teams */

struct bn_team {
    lock own;            /* guards the fields down to `stopped` */
    condition changed;   /* of size or generation */
    uint32_t size;       /* 0 until all threads have been started */
    uint32_t waiting;    /* members at the barrier */
    uint32_t generation; /* barriers that have been passed */
    uint32_t next;       /* the counter of bn_team_next() */
    int stopped;
    bn_team_work work;
    void *user;
};

void bn_team_wait(bn_team *team) {
    lock_take(&team->own);
    const uint32_t generation = team->generation;
    BN_ASSERT(team->waiting < team->size);
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
    BN_ASSERT(member->index < size);
    team->work(team->user, team, member->index, size);
}

uint32_t bn_team_threads(uint32_t option) {
    const uint32_t threads = option != 0 ? option : bn_thread_count();
    return threads < BN_TEAM_MOST ? threads : BN_TEAM_MOST;
}

void bn_team_run(uint32_t threads, bn_team_work work, void *user) {
    team_member members[BN_TEAM_MOST];
    thread started[BN_TEAM_MOST];
    bn_team team = {LOCK_INITIALIZER, CONDITION_INITIALIZER, .work = work, .user = user};
    uint32_t size = 1;
    for (; size < threads && size < BN_TEAM_MOST; ++size) {
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
