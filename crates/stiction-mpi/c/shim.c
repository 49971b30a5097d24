/* What Stiction needs of MPI, in bytes. Every function returns 0, or a code of MPI. Messages longer than a part are
 * sent in parts, because counts are ints. */

#include <mpi.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define PART ((uint64_t)1 << 30)
#define TAG 17

int shim_init(void) {
    int level = 0;
    int failed = MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level);
    if (failed) return failed;
    return level >= MPI_THREAD_FUNNELED ? 0 : -1;
}

int shim_rank(void) {
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return rank;
}

int shim_size(void) {
    int size = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    return size;
}

void shim_abort(int code) { MPI_Abort(MPI_COMM_WORLD, code); }

int shim_finalize(void) { return MPI_Finalize(); }

static uint64_t parts(uint64_t bytes) { return (bytes + PART - 1) / PART; }

static int length(uint64_t bytes, uint64_t part) {
    uint64_t left = bytes - part * PART;
    return (int)(left < PART ? left : PART);
}

/* Tells each of `receivers` how many bytes come, and learns it of each of `senders`. */
int shim_lengths(int receivers, const int *to, const uint64_t *out, int senders, const int *from, uint64_t *in) {
    MPI_Request *requests = malloc((size_t)(receivers + senders + 1) * sizeof *requests);
    if (!requests) return -2;
    int count = 0, failed = 0;
    for (int k = 0; k < senders && !failed; k++)
        failed = MPI_Irecv(&in[k], 1, MPI_UINT64_T, from[k], TAG, MPI_COMM_WORLD, &requests[count++]);
    for (int k = 0; k < receivers && !failed; k++)
        failed = MPI_Isend(&out[k], 1, MPI_UINT64_T, to[k], TAG, MPI_COMM_WORLD, &requests[count++]);
    if (!failed) failed = MPI_Waitall(count, requests, MPI_STATUSES_IGNORE);
    free(requests);
    return failed;
}

/* Sends `out` and receives `in`, whose lengths are known on both sides. Messages between two ranks keep their order. */
int shim_messages(int receivers, const int *to, const uint64_t *sizes, const void *const *out, int senders,
                  const int *from, const uint64_t *lengths, void *const *in) {
    uint64_t all = 1;
    for (int k = 0; k < receivers; k++) all += parts(sizes[k]);
    for (int k = 0; k < senders; k++) all += parts(lengths[k]);
    MPI_Request *requests = malloc((size_t)all * sizeof *requests);
    if (!requests) return -2;
    int count = 0, failed = 0;
    for (int k = 0; k < senders; k++)
        for (uint64_t p = 0; p < parts(lengths[k]) && !failed; p++)
            failed = MPI_Irecv((char *)in[k] + p * PART, length(lengths[k], p), MPI_BYTE, from[k], TAG, MPI_COMM_WORLD,
                               &requests[count++]);
    for (int k = 0; k < receivers; k++)
        for (uint64_t p = 0; p < parts(sizes[k]) && !failed; p++)
            failed = MPI_Isend((const char *)out[k] + p * PART, length(sizes[k], p), MPI_BYTE, to[k], TAG,
                               MPI_COMM_WORLD, &requests[count++]);
    if (!failed) failed = MPI_Waitall(count, requests, MPI_STATUSES_IGNORE);
    free(requests);
    return failed;
}
