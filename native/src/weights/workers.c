/* SPDX-License-Identifier: GPL-3.0-or-later */
/* clock_gettime and sysconf are POSIX, which plain C11 hides. */
#define _POSIX_C_SOURCE 200809L

#include "weights/workers.h"

#include "memory.h"

#include <pthread.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

typedef struct work_crew {
    work_function work;
    void *context;
    int32_t count;
    atomic_int next, stop, finished;
    pthread_mutex_t lock; /* of what follows */
    pthread_cond_t left;  /* a thread has ended */
    int32_t running;
    tug_status status;
    char text[1024]; /* error texts are per thread: that of the first failure is carried over */
} work_crew;

typedef struct crew_thread {
    pthread_t thread;
    work_crew *crew;
    int32_t worker;
} crew_thread;

int32_t processor_count(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count < 1 ? 1 : count > 1024 ? 1024 : (int32_t)count;
}

static void record_failure(work_crew *crew, tug_status status)
{
    pthread_mutex_lock(&crew->lock);
    if (crew->status == TUG_OK && !atomic_load(&crew->stop)) {
        crew->status = status;
        snprintf(crew->text, sizeof crew->text, "%s", tug_error_text());
    }
    atomic_store(&crew->stop, 1);
    pthread_mutex_unlock(&crew->lock);
}

static void *run_thread(void *argument)
{
    crew_thread *self = argument;
    work_crew *crew = self->crew;
    while (!atomic_load(&crew->stop)) {
        int32_t item = atomic_fetch_add(&crew->next, 1);
        if (item >= crew->count) {
            break;
        }
        tug_status status = crew->work(crew->context, self->worker, item, &crew->stop);
        if (status != TUG_OK) {
            record_failure(crew, status);
        }
        atomic_fetch_add(&crew->finished, 1);
    }
    pthread_mutex_lock(&crew->lock);
    crew->running--;
    pthread_cond_signal(&crew->left);
    pthread_mutex_unlock(&crew->lock);
    return NULL;
}

static struct timespec next_tick(void)
{
    struct timespec time;
    clock_gettime(CLOCK_REALTIME, &time);
    time.tv_nsec += 50000000;
    time.tv_sec += time.tv_nsec / 1000000000;
    time.tv_nsec %= 1000000000;
    return time;
}

/* Until all threads have ended; the callback runs without the lock. */
static tug_status watch(work_crew *crew, const progress_range *range, const char *stage)
{
    tug_status status = TUG_OK;
    pthread_mutex_lock(&crew->lock);
    while (crew->running > 0) {
        struct timespec tick = next_tick();
        pthread_cond_timedwait(&crew->left, &crew->lock, &tick);
        pthread_mutex_unlock(&crew->lock);
        if (status == TUG_OK) {
            status = report(range, stage, (double)atomic_load(&crew->finished) / crew->count);
        }
        pthread_mutex_lock(&crew->lock);
        if (status != TUG_OK) {
            atomic_store(&crew->stop, 1);
        }
    }
    pthread_mutex_unlock(&crew->lock);
    return status;
}

static int32_t start_threads(work_crew *crew, crew_thread *threads, int32_t count)
{
    int32_t started = 0;
    pthread_mutex_lock(&crew->lock);
    for (; started < count; started++) {
        threads[started].crew = crew;
        threads[started].worker = started;
        if (pthread_create(&threads[started].thread, NULL, run_thread, &threads[started]) != 0) {
            break;
        }
        crew->running++;
    }
    pthread_mutex_unlock(&crew->lock);
    return started;
}

tug_status run_workers(int32_t threads, int32_t count, work_function work, void *context,
                       const progress_range *range, const char *stage)
{
    work_crew crew = {.work = work, .context = context, .count = count};
    crew_thread *list = allocate((size_t)threads, sizeof *list);
    if (list == NULL) {
        return fail_memory();
    }
    pthread_mutex_init(&crew.lock, NULL);
    pthread_cond_init(&crew.left, NULL);
    int32_t started = start_threads(&crew, list, threads < count ? threads : count);
    tug_status status = watch(&crew, range, stage);
    for (int32_t i = 0; i < started; i++) {
        pthread_join(list[i].thread, NULL);
    }
    pthread_cond_destroy(&crew.left);
    pthread_mutex_destroy(&crew.lock);
    release(list);
    if (status == TUG_OK && crew.status != TUG_OK) {
        status = fail(crew.status, "%s", crew.text);
    }
    if (status == TUG_OK && started == 0 && count > 0) {
        status = fail(TUG_ERROR_MEMORY, "no thread could be started");
    }
    return status;
}
