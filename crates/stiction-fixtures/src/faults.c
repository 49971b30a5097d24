/* Counts what a process does to files below SHIM_FOLDER and does SHIM_DO at call number SHIM_AT, or sends a signal
   SHIM_AFTER microseconds after the start. At the end the number of calls is written to SHIM_COUNT. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum { PASS, REFUSED, HALF };
enum { OPEN, WRITE, OTHER };

static atomic_long calls;
static atomic_int broken;

static int asked(const char *what) {
    const char *task = getenv("SHIM_DO");
    return task && strcmp(task, what) == 0;
}

static void die(void) {
    kill(getpid(), SIGKILL);
    for (;;) pause();
}

/* What becomes of this call. */
static int verdict(const char *path, int kind) {
    const char *folder = getenv("SHIM_FOLDER"), *at = getenv("SHIM_AT");
    if (!folder || !strstr(path, folder)) return PASS;
    long number = ++calls;
    int now = at && number == atol(at);
    if (now && asked("kill")) die();
    if (now && asked("term")) kill(getpid(), SIGTERM);
    if (now && asked("int")) kill(getpid(), SIGINT);
    if (now && asked("half")) {
        if (kind == WRITE) return HALF;
        die();
    }
    if (now && (asked("full") || asked("dead"))) {
        broken = 1;
        if (kind == WRITE && asked("full")) return HALF;
    }
    /* A full disk still takes names away and syncs; a dead one does nothing. */
    int refused = (now && (asked("enospc") || asked("eio"))) || (broken && (kind != OTHER || asked("dead")));
    if (refused) errno = asked("eio") || asked("dead") ? EIO : ENOSPC;
    return refused ? REFUSED : PASS;
}

static int of_file(int fd, int kind) {
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    path[length < 0 ? 0 : length] = 0;
    return verdict(path, kind);
}

static int opened(const char *path, int flags, mode_t mode) {
    char full[8192];
    char here[4096];
    int relative = path[0] != '/' && getcwd(here, sizeof here);
    snprintf(full, sizeof full, "%s/%s", relative ? here : "", path);
    if (flags & (O_CREAT | O_WRONLY | O_RDWR) && verdict(full, flags & O_CREAT ? OPEN : OTHER) == REFUSED) return -1;
    return syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

int open(const char *path, int flags, ...) {
    va_list rest;
    va_start(rest, flags);
    mode_t mode = flags & O_CREAT ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    return opened(path, flags, mode);
}

int open64(const char *path, int flags, ...) {
    va_list rest;
    va_start(rest, flags);
    mode_t mode = flags & O_CREAT ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    return opened(path, flags | O_LARGEFILE, mode);
}

ssize_t write(int fd, const void *bytes, size_t count) {
    int then = of_file(fd, WRITE);
    if (then == REFUSED) return -1;
    ssize_t done = syscall(SYS_write, fd, bytes, then == HALF ? (count + 1) / 2 : count);
    if (then == HALF && asked("half")) die();
    return done;
}

ssize_t writev(int fd, const struct iovec *parts, int count) {
    int then = of_file(fd, WRITE);
    if (then == REFUSED) return -1;
    ssize_t done = syscall(SYS_writev, fd, parts, then == HALF ? 1 : count);
    if (then == HALF && asked("half")) die();
    return done;
}

int fsync(int fd) { return of_file(fd, OTHER) == REFUSED ? -1 : syscall(SYS_fsync, fd); }

int ftruncate64(int fd, off64_t size) { return of_file(fd, OTHER) == REFUSED ? -1 : syscall(SYS_ftruncate, fd, size); }

static int named(const char *path, int kind) {
    char full[8192], here[4096];
    int relative = path[0] != '/' && getcwd(here, sizeof here);
    snprintf(full, sizeof full, "%s/%s", relative ? here : "", path);
    return verdict(full, kind) == REFUSED;
}

int rename(const char *from, const char *to) {
    return named(to, OTHER) ? -1 : syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

int unlink(const char *path) { return named(path, OTHER) ? -1 : syscall(SYS_unlinkat, AT_FDCWD, path, 0); }

int mkdir(const char *path, mode_t mode) {
    return named(path, OPEN) ? -1 : syscall(SYS_mkdirat, AT_FDCWD, path, mode);
}

static void *later(void *unused) {
    (void)unused;
    usleep(atol(getenv("SHIM_AFTER")));
    if (asked("kill")) die();
    int number = asked("int") ? SIGINT : SIGTERM;
    struct sigaction now;
    /* Before the program listens a signal ends it as it ends any program. */
    while (sigaction(number, 0, &now) == 0 && now.sa_handler == SIG_DFL) usleep(100);
    kill(getpid(), number);
    return 0;
}

__attribute__((constructor)) static void begin(void) {
    pthread_t thread;
    if (getenv("SHIM_AFTER")) pthread_create(&thread, 0, later, 0);
}

__attribute__((destructor)) static void end(void) {
    const char *path = getenv("SHIM_COUNT");
    if (!path) return;
    char text[32];
    int length = snprintf(text, sizeof text, "%ld", (long)calls);
    int fd = syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (fd >= 0 && syscall(SYS_write, fd, text, length) == length) syscall(SYS_close, fd);
}
