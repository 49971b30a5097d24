/*
 * What METIS takes from GKlib and from the C library, written anew for one purpose: memory that is freed whole when a call is
 * left early, random numbers of its own, sorting. No signal is handled, raised or waited for.
 */

#include <stdarg.h>

#include "metislib.h"

#if defined(_MSC_VER)
#define OF_THREAD static __declspec(thread)
#else
#define OF_THREAD static __thread
#endif

/* How a call ends; the numbers are known to lib.rs. */
enum { ORDERED = 0, OUT_OF_MEMORY = 1, STOPPED = 2, LEFT_OUT = 3 };

/* What stands before each piece of memory. */
typedef struct block {
  struct block *before, *after; /* All blocks of the call. */
  struct block *below;          /* Those of the workspace, the last one first. */
  size_t bytes;
} block;

/* Functions that hold a part of the workspace at a time; METIS nests six. */
#define MOST_MARKS 64

/* The present call on this thread. */
OF_THREAD struct {
  jmp_buf landing;
  int code;
  int (*stop)(const void *);
  const void *told_to_stop;
  size_t bytes, most_bytes;
  block *blocks;

  /* The workspace: a stack in one piece of memory, and blocks for what does not fit. */
  char *core;
  size_t core_size, core_at;
  block *spilled;
  int marks;
  struct { size_t core_at; block *spilled; } mark[MOST_MARKS];

  uint32_t random[31];
  int front, back;
} run;


/* Leaves the call; its memory is freed where it lands. Only frames of C are left. */
static void leave(int code)
{
  run.code = code;
  longjmp(run.landing, 1);
}

static int left_out(void)
{
  leave(LEFT_OUT);
  return 0;
}

static void leave_if_stopped(void)
{
  if (run.stop(run.told_to_stop))
    leave(STOPPED);
}


/* ---------------------------------------------------------------- memory */

static void link_block(block *b)
{
  b->before = NULL;
  b->after = run.blocks;
  if (b->after != NULL)
    b->after->before = b;
  run.blocks = b;
  run.bytes += b->bytes;
}

static void unlink_block(block *b)
{
  if (b->before != NULL)
    b->before->after = b->after;
  else
    run.blocks = b->after;
  if (b->after != NULL)
    b->after->before = b->before;
  run.bytes -= b->bytes;
}

/* The block with room for so many bytes, in place of `old` if there is one; what is held is what was held if there is none. */
static block *allocated(block *old, size_t bytes)
{
  size_t held = run.bytes - (old != NULL ? old->bytes : 0);
  block *b;

  leave_if_stopped();
  if (bytes > SIZE_MAX - sizeof(block) || held > run.most_bytes || bytes > run.most_bytes - held)
    leave(OUT_OF_MEMORY);
  if (old != NULL)
    unlink_block(old);
  b = (block *)realloc(old, sizeof(block) + bytes);
  if (b == NULL) {
    if (old != NULL)
      link_block(old);
    leave(OUT_OF_MEMORY);
  }
  b->bytes = bytes;
  link_block(b);
  return b;
}

static void *gk_malloc(size_t bytes, const char *what)
{
  (void)what;
  return allocated(NULL, bytes) + 1;
}

static void *gk_realloc(void *old, size_t bytes, const char *what)
{
  (void)what;
  return allocated(old != NULL ? (block *)old - 1 : NULL, bytes) + 1;
}

static void free_one(void **pointer)
{
  if (*pointer != NULL) {
    block *b = (block *)*pointer - 1;
    unlink_block(b);
    free(b);
    *pointer = NULL;
  }
}

/* Frees what the pointers point to, up to LTERM, and sets them to NULL. */
static void gk_free(void **first, ...)
{
  va_list rest;
  void **pointer;

  free_one(first);
  va_start(rest, first);
  while ((pointer = va_arg(rest, void **)) != LTERM)
    free_one(pointer);
  va_end(rest);
}

static void free_all(void)
{
  while (run.blocks != NULL) {
    block *b = run.blocks;
    run.blocks = b->after;
    free(b);
  }
  run.bytes = 0;
}


/* ---------------------------------------------------------------- workspace */

static void wspacepush(void)
{
  if (run.marks == MOST_MARKS)
    leave(LEFT_OUT);
  run.mark[run.marks].core_at = run.core_at;
  run.mark[run.marks].spilled = run.spilled;
  run.marks++;
}

static void wspacepop(void)
{
  run.marks--;
  run.core_at = run.mark[run.marks].core_at;
  while (run.spilled != run.mark[run.marks].spilled) {
    void *memory = run.spilled + 1;
    run.spilled = run.spilled->below;
    gk_free(&memory, LTERM);
  }
}

static void *wspacemalloc(size_t bytes)
{
  block *b;

  leave_if_stopped();
  bytes = (bytes + 15) / 16 * 16;
  if (bytes <= run.core_size - run.core_at) {
    run.core_at += bytes;
    return run.core + (run.core_at - bytes);
  }
  b = allocated(NULL, bytes);
  b->below = run.spilled;
  run.spilled = b;
  return b + 1;
}


/* ---------------------------------------------------------------- vectors */

static idx_t *iset(size_t n, idx_t value, idx_t *x)
{
  size_t i;

  for (i = 0; i < n; i++)
    x[i] = value;
  return x;
}

static idx_t *icopy(size_t n, const idx_t *a, idx_t *b)
{
  return (idx_t *)memmove(b, a, n * sizeof(idx_t));
}

static idx_t isum(size_t n, const idx_t *x, size_t stride)
{
  size_t i;
  idx_t sum = 0;

  for (i = 0; i < n; i++)
    sum += x[i * stride];
  return sum;
}

static idx_t *ismalloc(size_t n, idx_t value, const char *what)
{
  return iset(n, value, imalloc(n, what));
}


/* ---------------------------------------------------------------- random numbers */

/* The generator of the GNU C library, whose numbers METIS draws there: an additive feedback generator (x^31 + x^3 + 1) begun by
 * a linear congruential one (Park & Miller 1988). Of its own, the orders are the same on all systems and with all threads. */
static idx_t irand(void)
{
  uint32_t sum = run.random[run.front] + run.random[run.back];

  run.random[run.front] = sum;
  run.front = (run.front + 1) % 31;
  run.back = (run.back + 1) % 31;
  return (idx_t)(sum >> 1);
}

static void isrand(uint32_t seed)
{
  int64_t x = seed != 0 ? (int32_t)seed : 1;
  int i;

  run.random[0] = (uint32_t)x;
  for (i = 1; i < 31; i++) {
    x = 16807 * x % 2147483647;
    if (x < 0)
      x += 2147483647;
    run.random[i] = (uint32_t)x;
  }
  run.front = 3;
  run.back = 0;
  for (i = 0; i < 310; i++)
    irand();
}

static idx_t irandInRange(idx_t end)
{
  return irand() % end;
}

/* Permutes an array, 0 to n-1 if it is fresh; few exchanges of four where it is long. As METIS does it. */
static void irandArrayPermute(idx_t n, idx_t *p, idx_t shuffles, int fresh)
{
  idx_t i, u, v, k, tmp;

  if (fresh) {
    for (i = 0; i < n; i++)
      p[i] = i;
  }
  if (n < 10) {
    for (i = 0; i < n; i++) {
      v = irandInRange(n);
      u = irandInRange(n);
      SWAP(p[v], p[u], tmp);
    }
    return;
  }
  for (i = 0; i < shuffles; i++) {
    v = irandInRange(n - 3);
    u = irandInRange(n - 3);
    for (k = 0; k < 4; k++)
      SWAP(p[v + k], p[u + (k + 2) % 4], tmp);
  }
}


/* ---------------------------------------------------------------- sorting */

/* Parts of so many pairs less one are left to the last pass. */
#define SMALL_PART 8

/* Quicksort (Hoare 1962) with the median of three, which leaves small parts unsorted (Sedgewick 1978). The larger part waits. */
static void sort_roughly(ikv_t *low, ikv_t *high)
{
  ikv_t tmp;

  while (high - low >= SMALL_PART) {
    ikv_t *middle = low + ((high - low) >> 1);
    ikv_t *left = low + 1, *right = high - 1;

    if (middle->key < low->key)
      SWAP(*middle, *low, tmp);
    if (high->key < middle->key) {
      SWAP(*middle, *high, tmp);
      if (middle->key < low->key)
        SWAP(*middle, *low, tmp);
    }
    do {
      while (left->key < middle->key)
        left++;
      while (middle->key < right->key)
        right--;
      if (left < right) {
        SWAP(*left, *right, tmp);
        if (middle == left)
          middle = right;
        else if (middle == right)
          middle = left;
        left++;
        right--;
      }
      else if (left == right) {
        left++;
        right--;
        break;
      }
    } while (left <= right);

    /* Both parts are sorted, the smaller one first: the depth is the logarithm of the length. */
    if (right - low < high - left) {
      if (right - low > SMALL_PART)
        sort_roughly(low, right);
      low = left;
    }
    else {
      if (high - left > SMALL_PART)
        sort_roughly(left, high);
      high = right;
    }
    if (high - low <= SMALL_PART)
      return;
  }
}

/* Sorts pairs by their keys. Which of equal ones comes first decides orders, and is as in METIS, which has its quicksort from
 * the GNU C library. */
static void ikvsorti(size_t n, ikv_t *x)
{
  size_t i, j, least = 0;
  ikv_t tmp;

  if (n < 2)
    return;
  sort_roughly(x, x + n - 1);
  for (i = 1; i < n && i <= SMALL_PART; i++) {
    if (x[i].key < x[least].key)
      least = i;
  }
  SWAP(x[0], x[least], tmp);
  for (i = 2; i < n; i++) {
    tmp = x[i];
    for (j = i; tmp.key < x[j - 1].key; j--)
      x[j] = x[j - 1];
    x[j] = tmp;
  }
}
